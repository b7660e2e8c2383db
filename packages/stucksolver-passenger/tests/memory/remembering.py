"""Episodes, and a road that only a way round leads past: what a passenger knows and the rules do not."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver import StuckSolver
from stucksolver.plan import Replan
from stucksolver.scene import CandidateWaypoint, DirectedSide, GuidanceIntent, Interpretation, LineKind, ObjectKind
from stucksolver_passenger.memory import SceneFeatures, Solution, SolutionOutcome, TriedSolution
from worlds import LANE_M, NAMES, World, ladder, straight_road, thing

REROUTE = Solution(intent=GuidanceIntent.REROUTE)
BACK_UP = Solution(intent=GuidanceIntent.BACK_UP)
LEFT = Solution(intent=GuidanceIntent.OVERTAKE, side=DirectedSide.LEFT)
RIGHT = Solution(intent=GuidanceIntent.OVERTAKE, side=DirectedSide.RIGHT)
ASKING = ladder(
    rungs={
        "reasoner": {"tries": 2, "cooldown_s": 0.5, "repair_rounds": 0},
        "passenger": {"within_s": 8.0},
        "remote": {"pull_over": False},
    }
)
"""Two tries of the rules, then the passenger is asked what to do, then help is called."""


def features(**changes) -> SceneFeatures:
    told = {
        "obstacle": "debris",
        "motion": "standing",
        "light": "none",
        "hazard_lights": False,
        "left": "blocked",
        "right": "none",
        "oncoming": "none",
        "people": False,
        "detour": True,
    }
    return SceneFeatures.model_validate(told | changes)


def reading(intent: GuidanceIntent, side: DirectedSide | None = None) -> Interpretation:
    return Interpretation(intent=intent, side=side, confidence=0.95, likely=intent, reader="test")


def episode(
    solution=REROUTE, ending=SolutionOutcome.WORKED, *, scene=None, text="take another street", at_s=1e9, **more
):
    told = {"at_s": at_s, "vehicle": "car-1", "scene": scene or features(), "ending": ending, "solution": solution}
    said = {} if solution is None or not text else {"text": text, "reading": reading(solution.intent)}
    return TriedSolution(**(told | said | more))


@dataclass
class BlockedRoad(World):
    """Debris over both of our lanes; where a new route is taken, the vehicle drives on along it."""

    def scene(self, seen=None):
        scene = super().scene(seen)
        other = CandidateWaypoint(
            id="other",
            lane_id="elsewhere",
            x_m=4.0,
            y_m=2.0,
            distance_m=4.5,
            reaches_destination=True,
            route_length_m=500.0,
        )
        return scene.model_copy(update={"waypoints": (other,)})

    def drive(self, directive):
        if isinstance(directive, Replan):
            self.objects = []
        super().drive(directive)


def blocked_road(shift_m: float = 0.0, kind: ObjectKind = ObjectKind.DEBRIS) -> BlockedRoad:
    size = {"kind": kind, "length": 1.0, "width": 1.6, "height": 0.9}
    row = [thing(f"d{k}", 75.0 + shift_m, -1.0 + 1.7 * k, **size) for k in range(1 + round((LANE_M + 2.0) / 1.7))]
    return BlockedRoad(straight_road(oncoming=None, left=LineKind.BROKEN), row, offers=NAMES)


def driven(world, seconds, *, words=None, reader=None, **options):
    """All events of a drive. `words`: said when the vehicle asks what to do."""
    events = []
    heard = options.pop("on_event", lambda event: None)

    def hear(event):
        events.append(event)
        heard(event)

    said = False
    settings = {"clock": "lockstep", "ladder": ASKING, "reader": reader, **options}
    with StuckSolver(world.scene, on_event=hear, **settings) as solver:
        for _ in range(round(seconds / world.dt)):
            if words is not None and not said and any(e.kind.value == "asked" for e in events):
                said = True
                solver.guide(words)
            world.drive(solver.step(world.status(), world.surroundings))
    return events
