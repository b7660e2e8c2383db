"""Chooses the speed of a pass through the oncoming lane: the slowest for which enough of the lane is seen."""

from __future__ import annotations

from stucksolver.reasoners.rules.pass_target import PassTarget, pass_distance_m
from stucksolver.reasoners.rules.recent_attempts import failed_for
from stucksolver.scene import VULNERABLE, LineKind, RejectCode, Scene, SceneLane

RECOVERY_MPS = 5.5
"""Just under the 20 km/h of a recovery."""
MOST_MPS = 11.0
"""Just under the 40 km/h of a pass."""
STEP_MPS = 0.5
USUAL_LIMIT_MPS = 50 / 3.6
"""Of oncoming traffic, if no limit is known: the common limit in towns."""
MARGIN_M, MARGIN_S = 12.0, 0.75
"""Sight that must remain on return, plus this time at the excess over `RECOVERY_MPS`. The guard requires a bit less."""
PEOPLE_ASIDE_M = 4.5
"""If people are nearer to the path than this, the pass is no faster than a recovery: more than the guard requires
(m).
"""


def pass_speed(scene: Scene, lane: SceneLane, target: PassTarget, speed_mps: float) -> float:
    """Return the speed to ask for (m/s).

    A faster pass is over sooner and needs less sight. The slowest speed with enough sight is the safest; if there is
    none, the one that lacks the least. More than `speed_mps` is asked for only past stationary objects, across a broken
    line, with nobody on foot or on a bicycle near, and within limits that are known.

    Args:
        scene: The scene.
        lane: The oncoming lane.
        target: What is passed.
        speed_mps: The speed to use unless there is a reason for more (m/s).
    """
    if speed_mps < RECOVERY_MPS or target.speed_mps > 0.1 or lane.line is LineKind.SOLID or lane.sight_ahead_m is None:
        return speed_mps
    if failed_for(scene, RejectCode.OVERSPEED, RejectCode.GAP, RejectCode.DOOR) or _people_beside(scene, target):
        return speed_mps
    if scene.speed_limit_mps is None or lane.speed_limit_mps is None:
        return speed_mps
    limit = min(scene.speed_limit_mps, lane.speed_limit_mps, MOST_MPS)
    count = int(max(limit - speed_mps, 0.0) / STEP_MPS)
    speeds = [speed_mps + STEP_MPS * k for k in range(count + 1)]
    lacking = {v: _needed_m(scene, lane, target, v) - lane.sight_ahead_m for v in speeds}
    return next((v for v in speeds if lacking[v] <= 0.0), min(speeds, key=lambda v: lacking[v]))


def seen_enough(scene: Scene, lane: SceneLane, target: PassTarget, speed_mps: float) -> bool:
    """True unless sensors see too little of the oncoming lane for a pass at a speed (m/s).

    At walking pace people are passed nearer, but twice as much of the lane must be seen. After a refusal for people,
    such a pass would be refused for sight, again and again, long after the people have gone.
    """
    sensed = any(o.position_sd_m for o in target.objects)
    return not sensed or (lane.sight_ahead_m or 0.0) >= _needed_m(scene, lane, target, speed_mps)


def _needed_m(scene: Scene, lane: SceneLane, target: PassTarget, speed_mps: float) -> float:
    """Return how much of the oncoming lane must be seen (m), by the rules' own estimate of distance and time."""
    way, time = pass_distance_m(scene, target, speed_mps)
    return way + (lane.speed_limit_mps or USUAL_LIMIT_MPS) * time + MARGIN_M + MARGIN_S * (speed_mps - RECOVERY_MPS)


def _people_beside(scene: Scene, target: PassTarget) -> bool:
    aside = scene.ego.width_m / 2 + PEOPLE_ASIDE_M
    return any(
        o.kind in VULNERABLE
        and o.gap_m is not None
        and -scene.ego.length_m < o.gap_m < target.end_m + scene.ego.length_m
        and o.right_edge_m < aside
        and o.left_edge_m > -aside
        for o in scene.objects
    )
