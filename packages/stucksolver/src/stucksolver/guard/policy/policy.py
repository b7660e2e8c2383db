"""The guard's policy: bounds that no plan may cross."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from pydantic import Field, NonNegativeFloat, field_validator

from stucksolver.guard.policy.approvals import RANKS, SCENES
from stucksolver.guard.policy.clearances import ClearancePolicy, DoorPolicy, PassablePolicy, PeoplePolicy
from stucksolver.guard.policy.ego import (
    HandBackPolicy,
    HarmPolicy,
    SpeedPolicy,
    StoppingPolicy,
    TrackingPolicy,
    TurningPolicy,
)
from stucksolver.guard.policy.other_road_users import EntryPolicy, OncomingPolicy, PredictionPolicy, RssPolicy
from stucksolver.guard.policy.road import (
    BackingPolicy,
    ControlPolicy,
    LanePolicy,
    QueuePolicy,
    ScenePolicy,
    SightPolicy,
)
from stucksolver.plan.behaviors import REGISTRY, ApprovalLevel
from stucksolver.plan.codes import WaitLimits
from stucksolver.scene.base_model import FrozenModel


class GuardPolicy(FrozenModel):
    """Numbers of the guard and the approvals that it requires. The defaults are the design's.

    The numbers are grouped in sub-policies by the checks that read them. Each has its unit in its name, and its origin
    in its description ("ours" means a choice of this project). All are finite and none is negative. The policy rejects
    unknown names.
    """

    releases: Mapping[str, ApprovalLevel] = Field(default_factory=dict)
    """Required approval of a behavior, by its name. Other behaviors keep their default."""
    solid_line: Literal["forbid", "autonomous", "passenger", "operator"] = "passenger"
    """Required approval for crossing a solid line past a stationary obstruction. Evaluation profiles set `autonomous`.
    """
    authority: ApprovalLevel = ApprovalLevel.OPERATOR
    """Required approval for passing a school bus, level crossing or flagger."""
    emergency_scene: ApprovalLevel = ApprovalLevel.OPERATOR
    """Required approval for passing a stopped emergency vehicle, unless a lane in the ego's direction is free."""
    waits: WaitLimits = Field(default_factory=WaitLimits)
    max_age_s: NonNegativeFloat = 0.5
    """Greatest age of surroundings that may prove anything (s). The design's: a few ticks of a slow stack."""

    clearance: ClearancePolicy = ClearancePolicy()
    people: PeoplePolicy = PeoplePolicy()
    doors: DoorPolicy = DoorPolicy()
    passable: PassablePolicy = PassablePolicy()

    prediction: PredictionPolicy = PredictionPolicy()
    rss: RssPolicy = RssPolicy()
    entry: EntryPolicy = EntryPolicy()
    oncoming: OncomingPolicy = OncomingPolicy()

    sight: SightPolicy = SightPolicy()
    lanes: LanePolicy = LanePolicy()
    controls: ControlPolicy = ControlPolicy()
    queues: QueuePolicy = QueuePolicy()
    scenes: ScenePolicy = ScenePolicy()
    backing: BackingPolicy = BackingPolicy()
    turning: TurningPolicy = TurningPolicy()

    speeds: SpeedPolicy = SpeedPolicy()
    tracking: TrackingPolicy = TrackingPolicy()
    stopping: StoppingPolicy = StoppingPolicy()
    harm: HarmPolicy = HarmPolicy()
    hand_back: HandBackPolicy = HandBackPolicy()

    @field_validator("releases")
    @classmethod
    def _known(cls, releases: Mapping[str, ApprovalLevel]) -> Mapping[str, ApprovalLevel]:
        unknown = sorted(set(releases) - set(REGISTRY))
        if unknown:
            raise ValueError(f"releases: unknown behavior {unknown[0]!r}; choose from: {', '.join(REGISTRY)}")
        return releases

    def laxer_than(self, other: GuardPolicy) -> tuple[str, ...]:
        """Return the behaviors and rules that this policy allows with a lower approval than another policy does."""
        levels: dict[str, tuple[str, str]] = {
            name: (self.release(name).value, other.release(name).value) for name in REGISTRY
        }
        levels |= {scene: (self.scene_release(scene).value, other.scene_release(scene).value) for scene in SCENES}
        levels["solid_line"] = (self.solid_line, other.solid_line)
        return tuple(name for name, (here, there) in levels.items() if RANKS.index(here) < RANKS.index(there))

    def scene_release(self, scene: str) -> ApprovalLevel:
        """Return the required approval for passing one of the scenes in `RULES`."""
        return self.emergency_scene if scene == "emergency_scene" else self.authority

    def release(self, behavior: str) -> ApprovalLevel:
        """Return the required approval of a behavior."""
        return self.releases.get(behavior, REGISTRY[behavior].release)
