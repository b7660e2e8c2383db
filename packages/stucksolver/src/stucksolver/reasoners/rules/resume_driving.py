"""Drives on along the free lane: the vehicle has stopped although nothing is in its way and nothing says to wait."""

from __future__ import annotations

from stucksolver.plan import RecoveryPlan, WaitReason
from stucksolver.plan.behaviors import AnyBehavior, Creep, KeepLane, RejoinRoute
from stucksolver.reasoners.rules.observe import drives, is_near_path
from stucksolver.reasoners.rules.pass_options import STANDS_MPS, Way
from stucksolver.reasoners.rules.recent_attempts import failed_for, has_been_tried
from stucksolver.scene import (
    ON_FOOT,
    ControlKind,
    GuidanceIntent,
    LightState,
    ObjectKind,
    RejectCode,
    Scene,
    SceneObject,
)

STANDS_S = 8.0
"""The stack is given this long to set off by itself, as crossing traffic is (`standoff.FIRST_TURN_S`) (s)."""
FREE_M = 50.0
"""Nothing may be in the path up to this distance, so that the exit of a junction ahead is free too (m)."""
ON_M, ON_MPS = 25.0, 5.5
"""Distance and speed on an open road: more than the 15 m of progress that count as a recovery."""
SLOWLY_M, SLOWLY_MPS = 20.0, 2.2
"""The same near stop lines, people and traffic: across a junction, at walking pace."""
CREEP_M = 5.0
"""If even that was refused: a short distance, to see more (m)."""
LINE_M, PEOPLE_M = 30.0, 25.0
"""A stop line or people nearer than this ahead require walking pace (m)."""
SCENE_M, SCENE_BESIDE_M = 45.0, 8.0
"""A flagger, gate or school bus counts up to this distance ahead and to the side (m), as in `guard.traffic_rules`."""
SCENES = frozenset({ObjectKind.FLAGGER, ObjectKind.CROSSING_GATE, ObjectKind.SCHOOL_BUS})
SIREN_M = 80.0
"""A moving emergency vehicle with its lights on within this distance goes first (m)."""


def resume(scene: Scene) -> Way | None:
    """Drive on in the lane, or back into it; None if the stop has been short, or something is in the path.

    Queues, crossing people and traffic that goes first are reasons to wait, and have been checked before. A passenger
    may also ask for it.
    """
    asked = None if scene.guidance is None or scene.guidance.reading is None else scene.guidance.reading.intent
    if asked not in (None, GuidanceIntent.GO) or scene.in_path_ahead(FREE_M):
        return None
    if scene.ego.speed_mps > STANDS_MPS or scene.ego.stopped_for_s < STANDS_S:
        return None
    holds = may_hold(scene)
    if holds is not None:
        return None, (WaitReason.YIELD, holds)
    onward = _onward(scene)
    if not scene.offers(onward.name):
        return None
    why = f"nothing is in the lane ahead, and the vehicle has stood for {scene.ego.stopped_for_s:.0f} s: drive on"
    return RecoveryPlan(behaviors=(onward,)), (None, why)


def _onward(scene: Scene) -> AnyBehavior:
    if all(lane.id != scene.ego.lane_id for lane in scene.lanes):
        return RejoinRoute(speed_mps=SLOWLY_MPS)
    if has_been_tried(scene, "keep_lane") and failed_for(
        scene, RejectCode.PATH_NOT_VISIBLE, RejectCode.COLLISION, RejectCode.GAP, RejectCode.CLEARANCE
    ):
        return Creep(distance_m=CREEP_M)
    if _open_road(scene):
        return KeepLane(distance_m=ON_M, speed_mps=ON_MPS)
    return KeepLane(distance_m=SLOWLY_M, speed_mps=SLOWLY_MPS)


def may_hold(scene: Scene) -> str | None:
    """Return, in words, who may rightly hold the vehicle up without being in its path, or None."""
    for control in scene.controls:
        lit = control.kind is ControlKind.TRAFFIC_LIGHT and control.state not in (LightState.GREEN, LightState.OFF)
        if lit and control.applies is not False and -1.0 < control.distance_m < LINE_M:
            return "a light ahead is not known to be green"
    for o in scene.objects:
        aside_m = min(abs(o.left_edge_m), abs(o.right_edge_m))
        if o.kind in SCENES and -10.0 < (o.gap_m or 0.0) < SCENE_M and aside_m < SCENE_BESIDE_M:
            return f"{o.kind.value} {o.id} may be holding up the traffic"
        if _sounds(o):
            return f"{o.kind.value} {o.id} has its lights on and goes first"
        comes = o.speed_across_mps * (o.left_edge_m + o.right_edge_m) < 0.0
        if _crosses(o) and comes:
            return f"{o.kind.value} {o.id} is coming from the side and goes first"
    return None


def siren_behind(scene: Scene) -> SceneObject | None:
    """Return an emergency vehicle with its lights on that comes up from behind, or None."""
    return next((o for o in scene.objects if _sounds(o) and o.x_m < 0.0 and o.speed_along_mps > 0.0), None)


def _sounds(o: SceneObject) -> bool:
    return o.kind is ObjectKind.EMERGENCY and bool(o.emergency_lights) and drives(o) and _away_m(o) < SIREN_M


def _crosses(o: SceneObject) -> bool:
    return drives(o) and _away_m(o) < FREE_M and abs(o.speed_across_mps) > abs(o.speed_along_mps)


def _away_m(o: SceneObject) -> float:
    return float((o.x_m**2 + o.y_m**2) ** 0.5)


def _open_road(scene: Scene) -> bool:
    """True if there is only road ahead: no stop line, no people and no crossing vehicle."""
    if any(c.applies is not False and -1.0 < c.distance_m < LINE_M for c in scene.controls):
        return False
    for o in scene.objects:
        ahead = -scene.ego.length_m < (o.gap_m or 0.0) < PEOPLE_M
        if o.kind in ON_FOOT and ahead and is_near_path(o):
            return False
        if _crosses(o):
            return False
    return True
