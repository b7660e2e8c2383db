"""What the stack says of itself on every tick; cheap enough to be built always."""

from stucksolver.scene.model import Model


class Status(Model):
    """The progress of the ego at one tick."""

    time_s: float
    """Simulation or wall time, never running backwards."""
    speed_mps: float
    progress_m: float
    """High-water mark of the arc length driven along the route, without what was driven pushing something along."""
    pushes: bool = False
    """Does it push something along? Then it is immobilized, at whatever speed."""
    at_destination: bool = False
