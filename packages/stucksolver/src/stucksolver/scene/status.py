"""What the stack reports about itself on every tick; cheap enough to build each time."""

from stucksolver.scene.base_model import FrozenModel


class Status(FrozenModel):
    """The progress of the ego at one tick."""

    time_s: float
    """Simulation or wall time (s); never runs backwards, and never stands still from tick to tick."""
    speed_mps: float
    """Speed without a sign (m/s), also in reverse."""
    progress_m: float
    """The greatest arc length reached along the route so far (m), without the distance driven while pushing
    something.
    """
    pushes: bool = False
    """True if the ego is pushing something along. It then counts as immobilized at any speed."""
    at_destination: bool = False
