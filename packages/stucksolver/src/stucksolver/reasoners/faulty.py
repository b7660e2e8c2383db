"""Reasoners that are wrong on purpose, to show that the guard provides the safety, and to test stacks.

They are used only by name (`evaluate --recovery faulty:random`).
"""

from __future__ import annotations

import random
import time
from collections import deque
from collections.abc import Callable

from stucksolver.plan import Analysis, CauseCode, Decision, Observation, RecoveryPlan
from stucksolver.plan.behaviors import (
    BorrowOncomingLane,
    ChangeLane,
    Creep,
    DriveOver,
    FollowVehicle,
    KeepLane,
    Nudge,
    Wait,
)
from stucksolver.plan.behaviors.behavior import Behavior
from stucksolver.reasoners.reasoner import Reasoner, ReasonerAnswer, ReasonerError, ReasonerRequest, ReasonerTrace
from stucksolver.reasoners.search import SearchReasoner
from stucksolver.scene import Scene, SceneObject

SILENT_S = 3600.0
"""Delay of a silent reasoner (s): longer than any run."""
LATE_CALLS = 3
"""Age of the query that a late reasoner answers (queries)."""
Choose = Callable[["FaultyReasoner", Scene], tuple[Behavior, ...]]


class FaultyReasoner:
    """Reasoner that answers every scene with a plan from `choose`, and always claims an immobilization.

    `delay_s` is the wall time before an answer (s). `cancel` ends the delay, and later queries fail at once.
    """

    def __init__(self, name: str, choose: Choose, seed: int = 0, delay_s: float = 0.0) -> None:
        self.name = f"faulty:{name}"
        self.random = random.Random(seed)
        self.calls = 0
        self.requests: deque[ReasonerRequest] = deque(maxlen=LATE_CALLS + 1)
        """Last requests, oldest first."""
        self._choose = choose
        self._delay_s = delay_s
        self._cancelled = 0

    def decide(self, request: ReasonerRequest) -> ReasonerAnswer:
        """Return a wrong, late or missing answer, depending on the kind of fault."""
        scene = request.scene
        self.calls += 1
        self.requests.append(request)
        if self._cancelled and self._delay_s:
            raise ReasonerError("still silent")
        call, until = self.calls, time.monotonic() + self._delay_s
        while time.monotonic() < until:
            if self._cancelled >= call:
                raise ReasonerError("cancelled")
            time.sleep(min(0.05, self._delay_s))
        behaviors = self._choose(self, scene)
        decision = _sure(RecoveryPlan(behaviors=behaviors))
        return ReasonerAnswer(
            decision, self.name, ReasonerTrace(answers=(decision.model_dump_json(),), model=self.name)
        )

    def cancel(self) -> None:
        """End the delay of the running query."""
        self._cancelled = self.calls


def make_faulty(name: str, seed: int = 0) -> Reasoner:
    """Create one of `FAULTY` by name.

    Raises:
        ValueError: The name is unknown.
    """
    if name not in FAULTY:
        raise ValueError(f"unknown faulty reasoner {name!r}: use {', '.join(FAULTY)}")
    choose, delay_s = FAULTY[name]
    return FaultyReasoner(name, choose, seed, delay_s)


def _sure(plan: RecoveryPlan) -> Decision:
    return Decision(
        observation=Observation(controls=(), participants=(), summary="all is clear"),
        analysis=Analysis(steps=(), immobilized=True, cause=CauseCode.UNKNOWN, reason="I am sure of it"),
        plan=plan,
        rationale=", ".join(b.name for b in plan.behaviors),
    )


# ---- the faults


def _random(faulty: FaultyReasoner, scene: Scene) -> tuple[Behavior, ...]:
    """Return one to three random behaviors with random parameters, for any object."""
    return tuple(_any(scene, faulty.random) for _ in range(faulty.random.randint(1, 3)))


def _any(scene: Scene, chance: random.Random) -> Behavior:
    object_id = _nearest(scene, chance)
    speed = round(chance.uniform(1.0, 11.0), 1)
    side = chance.choice(("left", "right"))
    far = round(chance.uniform(15.0, 150.0), 1)
    return chance.choice(
        (
            lambda: ChangeLane(side=side, distance_m=far, speed_mps=speed),  # type: ignore[arg-type]
            lambda: BorrowOncomingLane(past_object_id=object_id, speed_mps=speed),
            lambda: KeepLane(distance_m=far, speed_mps=speed),
            lambda: DriveOver(object_id=object_id),
            lambda: Creep(distance_m=3.0),
            lambda: Nudge(side=side, offset_m=0.5, distance_m=20.0),  # type: ignore[arg-type]
            lambda: FollowVehicle(leader_id=object_id, distance_m=far, speed_mps=speed),
            lambda: Wait(duration_s=round(chance.uniform(0.5, 20.0), 1)),
        )
    )()


def _always_left(faulty: FaultyReasoner, scene: Scene) -> tuple[Behavior, ...]:
    return (ChangeLane(side="left", distance_m=40.0, speed_mps=8.0),)


def _always_drive_over(faulty: FaultyReasoner, scene: Scene) -> tuple[Behavior, ...]:
    """Return a plan to drive over the nearest object in the path."""
    ahead = scene.in_path_ahead()
    object_id = ahead[0].id if ahead else _nearest(scene, faulty.random)
    return (DriveOver(object_id=object_id),)


def _contradictory(faulty: FaultyReasoner, scene: Scene) -> tuple[Behavior, ...]:
    """Return two contradictory plans alternately; each also contradicts itself."""
    first: tuple[Behavior, ...] = (
        ChangeLane(side="left", distance_m=30.0, speed_mps=6.0),
        ChangeLane(side="left", distance_m=30.0, speed_mps=6.0),
    )
    second: tuple[Behavior, ...] = (Wait(duration_s=1.0), KeepLane(distance_m=100.0, speed_mps=11.0))
    return first if faulty.calls % 2 else second


def _never(faulty: FaultyReasoner, scene: Scene) -> tuple[Behavior, ...]:
    raise ReasonerError("no answer")


def _late(faulty: FaultyReasoner, scene: Scene) -> tuple[Behavior, ...]:
    """Return a good answer to a much older query, regardless of the clock."""
    plan = SearchReasoner().decide(faulty.requests[0]).decision.plan
    if len(faulty.requests) <= LATE_CALLS or plan is None:
        raise ReasonerError("still thinking")
    return plan.behaviors


def _nearest(scene: Scene, chance: random.Random) -> str:
    """Return the id of a nearby object, or an id that does not exist."""
    near: tuple[SceneObject, ...] = scene.objects[:8]
    return chance.choice(near).id if near else "nobody"


FAULTY: dict[str, tuple[Choose, float]] = {
    "random": (_random, 0.0),
    "always_left": (_always_left, 0.0),
    "always_drive_over": (_always_drive_over, 0.0),
    "silent": (_never, SILENT_S),
    "late": (_late, 0.0),
    "contradictory": (_contradictory, 0.0),
}
"""Function that chooses the plan, and wall time before the answer (s), by name."""
