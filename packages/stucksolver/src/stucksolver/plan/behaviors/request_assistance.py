"""Ask a person for help while safely stopped."""

from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.plan.behaviors.behavior import PlanPhrase, StationaryBehavior
from stucksolver.plan.simple_directives import SafeStop
from stucksolver.scene.frenet_scene import FrenetScene

CLEAR_M = 25.0


class RequestAssistance(StationaryBehavior):
    """Stop with hazard lights on and ask the remote operator, until the path is free or the time is up."""

    summary: ClassVar[str] = (
        "Stop with hazard lights on and ask a remote operator for help, saying why; for at most duration_s seconds."
    )
    phrase: ClassVar[PlanPhrase] = PlanPhrase("stop and call the operator", "calling the operator")
    stopping_place_detail: ClassVar[str | None] = (
        "a call for assistance requires a stop outside junctions, crossings and oncoming lanes"
    )
    calls_person: ClassVar[bool] = True

    name: Literal["request_assistance"] = "request_assistance"
    reason: str = Field(max_length=200)
    duration_s: float = Field(default=30.0, ge=5.0, le=300.0)

    def directive(self) -> SafeStop:
        return SafeStop(reason=self.reason)

    def done(self, view: FrenetScene) -> bool:
        return view.free_ahead_m() > CLEAR_M

    def time_allowance_s(self, expected_s: float) -> float:
        return self.duration_s
