"""Words on signs, from a closed list: what a sign says reaches nobody in any other form."""

from enum import Enum

from stucksolver.scene.base_model import FrozenModel


class SignWord(str, Enum):
    """What a sign, a paddle or a vehicle's livery can be read to say."""

    STOP = "stop"
    YIELD = "yield"
    SLOW = "slow"
    ROAD_CLOSED = "road_closed"
    DETOUR = "detour"
    ROAD_WORK = "road_work"
    DO_NOT_ENTER = "do_not_enter"
    SCHOOL_BUS = "school_bus"
    POLICE = "police"
    AMBULANCE = "ambulance"
    FIRE = "fire"


class ObservedSign(FrozenModel):
    """A word that was read at least twice while the vehicle stood."""

    word: SignWord
    object_id: str | None = None
    """The tracked object that carries it; None if it is on no tracked object."""
    distance_m: float | None = None
    """Distance from the ego's centre (m); None if it is not known, or if an object carries it."""
    bearing_rad: float | None = None
    """Direction from the ego's heading, to the left positive; None if an object carries it."""
