"""The directives that name no behavior: drive on, replan the route, stop safely."""

from typing import Literal

from stucksolver.scene.base_model import FrozenModel


class Continue(FrozenModel):
    """Drive as if StuckSolver were not there."""

    kind: Literal["continue"] = "continue"


class Replan(FrozenModel):
    """Replan the route, from a candidate waypoint of the scene or from here (None)."""

    kind: Literal["replan"] = "replan"
    route_start: str | None = None


class SafeStop(FrozenModel):
    """Stop with hazard lights on and stay until another directive; nothing more can be done here."""

    kind: Literal["safe_stop"] = "safe_stop"
    reason: str
