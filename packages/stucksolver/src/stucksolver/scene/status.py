"""Report of the stack about itself on every tick; cheap enough to build each time."""

from stucksolver.scene.base_model import FrozenModel


class Status(FrozenModel):
    """Progress of the ego at one tick."""

    time_s: float
    """Simulation or wall time (s). It increases with every tick."""
    speed_mps: float
    """Speed without a sign (m/s), also in reverse."""
    progress_m: float
    """Greatest arc length reached along the route (m), without distance driven while pushing an object."""
    pushes: bool = False
    """True if the ego is pushing an object along. The ego then counts as immobilized at any speed."""
    at_destination: bool = False
    drives: bool | None = None
    """True if the accelerator is pressed and no brake is; None if the stack does not report it."""
