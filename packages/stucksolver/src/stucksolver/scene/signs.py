"""Words on signs, from a closed list. The text of a sign reaches reasoners in no other form."""

from enum import Enum

from stucksolver.scene.base_model import FrozenModel


class SignWord(str, Enum):
    """Meaning of the text on a sign, a paddle or a vehicle's livery."""

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
    """Word that was read at least twice while the ego was stopped."""

    word: SignWord
    object_id: str | None = None
    """Tracked object that carries the word; None if no tracked object does."""
    distance_m: float | None = None
    """Distance from the ego's center (m); None if unknown, or if an object carries the word."""
    bearing_rad: float | None = None
    """Direction from the ego's heading, left positive; None if an object carries the word."""
