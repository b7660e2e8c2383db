"""Crosses an endless stream of traffic: after a long enough wait, it takes the first gap that can be proven.

The rules only propose the path across. The guard checks it on every tick and lets it begin in a gap in which no traffic
that continues or brakes would hit the ego; without such a gap it never begins. The plan never leads into the lane of
the stream: at 20 km/h, traffic that does not brake would catch up beyond the end of what is proven.
"""

from __future__ import annotations

import math

from stucksolver.plan import RecoveryPlan, WaitReason
from stucksolver.plan.behaviors import AnyBehavior, KeepLane
from stucksolver.reasoners.rules.observe import drives, goes_first, on_route
from stucksolver.reasoners.rules.pass_options import Way
from stucksolver.scene import ControlKind, Scene, SceneObject

ACROSS_M, ACROSS_MPS = 30.0, 5.5
"""Far enough to clear a street of four lanes, at just under 20 km/h. The faster, the shorter the gap needed."""
OVER_LINE_M, CREEP_MPS = 2.0, 2.2
"""The ego creeps over a stop line until its bumper is this far past it (m): a little more than the guard requires."""
LINE_AHEAD_M = 8.0
SAME_WAY_COS, LANE_M = 0.5, 4.0
"""Traffic that heads within 60 degrees of the route's direction and passes within a lane's width of it (m)."""
AGAIN_S = 12.0
"""Pause after a wait for a gap that failed, so that a person can be asked: longer than such a wait (`hold_s`) (s)."""


def enter_flow(scene: Scene) -> Way | None:
    """Return a plan to drive on in the first proven gap, or why to wait; None if nobody has to go first."""
    first = goes_first(scene)
    if first is None or scene.guidance is not None or not scene.offers("keep_lane"):
        return None
    who = f"{first.kind.value} {first.id} and others"
    if any("keep_lane" in a.behaviors and scene.time_s - a.time_s < AGAIN_S for a in scene.attempts):
        return None, (WaitReason.YIELD, f"{who} leave no gap")
    if any(_shares_the_way_on(scene, o) for o in scene.objects):
        return None, (WaitReason.YIELD, f"{who} drive on where the route leads: no gap is long enough")
    plan = RecoveryPlan(behaviors=(*_over_the_line(scene), KeepLane(distance_m=ACROSS_M, speed_mps=ACROSS_MPS)))
    stood = f"{scene.ego.stopped_for_s:.0f} s"
    return plan, (None, f"{who} have left no gap for {stood}: go in the first one that is long enough")


def _shares_the_way_on(scene: Scene, o: SceneObject) -> bool:
    """True if a vehicle drives where the route continues beyond the crossing, in the same direction and lane."""
    route = [(w.x_m, w.y_m) for w in scene.waypoints if on_route(scene, w)]
    if len(route) < 2 or not drives(o):
        return False
    (x0, y0), (x1, y1) = route[-2:]
    way_m, speed_mps = math.hypot(x1 - x0, y1 - y0), math.hypot(o.vx_mps, o.vy_mps)
    along = ((x1 - x0) * o.vx_mps + (y1 - y0) * o.vy_mps) / (way_m * speed_mps) if way_m > 0.0 else 0.0
    aside_m = abs((x1 - o.x_m) * o.vy_mps - (y1 - o.y_m) * o.vx_mps) / speed_mps
    upstream = (x1 - o.x_m) * o.vx_mps + (y1 - o.y_m) * o.vy_mps > 0.0
    return along > SAME_WAY_COS and upstream and aside_m < LANE_M


def _over_the_line(scene: Scene) -> tuple[AnyBehavior, ...]:
    """Return a creep over the line of a stop sign just ahead, if any; dark lights are crossed at a creep anyway."""
    for control in scene.controls:
        binds = control.applies is not False and control.kind is ControlKind.STOP_SIGN
        if binds and 0.0 <= control.distance_m < LINE_AHEAD_M:
            return (KeepLane(distance_m=round(control.distance_m + OVER_LINE_M, 1), speed_mps=CREEP_MPS),)
    return ()
