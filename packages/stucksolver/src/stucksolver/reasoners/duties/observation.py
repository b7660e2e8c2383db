"""Step 1: what matters in the scene, and what each participant is about to do."""

from __future__ import annotations

import math

from shapely import LineString

from stucksolver.plan import Intent, Observation, ObservedControl, Participant, WaitLimits
from stucksolver.scene import (
    MOTOR_VEHICLES,
    STATIC_KINDS,
    VEHICLES,
    VULNERABLE,
    CandidateWaypoint,
    Claim,
    ControlKind,
    LaneRelation,
    LightState,
    ObjectKind,
    Scene,
    SceneObject,
)
from stucksolver.scene.wording import whereabouts

MOVING_MPS = 0.5
CROSSING_MPS = 0.3
KERB_ZONE_M = 2.0
"""People this near to the path may step into it (m)."""
LIKE_A_THING_S = 60.0
"""An animal that has not moved for this long, as seen by sensors, may be a box (s). Animals stand on a road for half a
minute."""
PARKED_OFFSET_M = 0.4
"""A vehicle further than this from the lane's center is beside the traffic, not in it (m)."""
AHEAD_M = 60.0
ACROSS_SIN = 0.6
"""Sine of the smallest angle to the path at which a vehicle counts as standing across it."""
JOINS_M = 1.0
"""A vehicle that crawls into the ego's lane is at least this far beside the path (m), ..."""
JOINS_RAD = 0.08
"""... turned towards it by at least this angle, ..."""
JOINS_AHEAD_M = 8.0
"""... at most this far ahead, ..."""
CRAWLS_MPS = 3.0
"""... and not faster than this."""
LET_IN_S = 20.0
"""If the ego is not let in for this long, it must show that it wants to go (s)."""
WAVED_S = 3.0
"""The same if a passenger says that it is let in: as long as a vehicle with hazard lights is watched (s)."""
SAME_WAY_COS = 0.9
SAME_LANE_M = 1.5
QUEUE_GAP_M = 8.0
YIELD_AHEAD_M = 42.0
"""Traffic that will come near the route up to this distance ahead (m) goes first, ..."""
YIELD_S = 5.0
"""... if it does so within this time (s) ..."""
YIELD_BESIDE_M = 2.0
"""... and comes nearer than this (m), which is less than a lane's width."""

ALONG_TAN = 0.35
"""Tangent of the largest angle to the road (about 20 degrees) at which a vehicle changes lanes."""
ROAD_HALF_WIDTH_M = 15.0
"""Further to the side than any lane of the route's road (m)."""


def observe(scene: Scene, limits: WaitLimits) -> Observation:
    """Return the traffic controls and the relevant participants, nearest first."""
    controls = tuple(
        ObservedControl(kind=c.kind, state=c.state, applies=c.applies, distance_m=round(c.distance_m, 1))
        for c in scene.controls
    )
    participants = tuple(
        Participant(object_id=o.id, kind=o.kind, lane=o.lane, distance_m=o.gap_m, intent=intent(scene, o, limits))
        for o in scene.objects
        if matters(o)
    )
    return Observation(controls=controls, participants=participants, summary=_summary(scene, participants))


def matters(o: SceneObject) -> bool:
    """True if it is in the path ahead, near it on foot, or moving in a lane that the ego might use."""
    gap = o.gap_m if o.gap_m is not None else 0.0
    if o.in_path and -1.0 < gap < AHEAD_M:
        return True
    if o.kind in (ObjectKind.PEDESTRIAN, ObjectKind.ANIMAL):
        return -5.0 < gap < 30.0 and is_near_path(o)
    if o.speed_along_mps < -MOVING_MPS and gap + o.length_m < 0.0:
        return False  # it came towards us and has passed
    return abs(o.speed_along_mps) > MOVING_MPS and o.lane in (
        LaneRelation.LEFT,
        LaneRelation.RIGHT,
        LaneRelation.ONCOMING,
    )


def is_near_path(o: SceneObject) -> bool:
    """True if it is within a step of the ego's lane."""
    return o.right_edge_m < KERB_ZONE_M + 1.0 and o.left_edge_m > -KERB_ZONE_M - 1.0


def intent(scene: Scene, o: SceneObject, limits: WaitLimits) -> Intent:
    """Return what an object is about to do, from its motion, position and lights."""
    thing = o.kind in STATIC_KINDS or o.kind is ObjectKind.UNKNOWN or is_static_like(o)
    if o.kind in (ObjectKind.PEDESTRIAN, ObjectKind.ANIMAL) and not thing:
        return _on_foot(o)
    if thing:
        return Intent.OBSTRUCTING if o.in_path else Intent.UNKNOWN
    if o.speed_along_mps < -MOVING_MPS:
        return Intent.ONCOMING
    if o.speed_along_mps > MOVING_MPS:
        return Intent.FOLLOWING
    if o.hazard_lights:
        return Intent.STOPPED
    if crosses(o):
        return Intent.QUEUEING if _in_queue_across(scene, o) else Intent.STOPPED
    if beside_lane_center(o):
        return Intent.PARKED
    return Intent.QUEUEING if _in_queue(scene, o, limits) else Intent.STOPPED


def is_static_like(o: SceneObject) -> bool:
    """True for an animal that has stood since sensors first saw it: boxes and cones are often taken for one.

    The guard still keeps as far from it as from any animal.
    """
    unmoved = o.moved_s_ago is None and (o.stationary_s or 0.0) >= LIKE_A_THING_S
    return o.kind is ObjectKind.ANIMAL and bool(o.position_sd_m) and unmoved


def is_staying(o: SceneObject) -> bool:
    """True if it will still be there however long the ego waits: a thing, or a broken-down vehicle."""
    return bool(o.hazard_lights) or o.kind not in MOTOR_VEHICLES | VULNERABLE or is_static_like(o)


def beside_lane_center(o: SceneObject) -> bool:
    """True if it is off the middle of the lane, as parked vehicles are."""
    return abs(o.left_edge_m + o.right_edge_m) / 2 > PARKED_OFFSET_M


def crosses(o: SceneObject) -> bool:
    """True if a vehicle is turned across the path, as on a crossing road."""
    return o.kind in MOTOR_VEHICLES and abs(math.sin(o.yaw_rad)) > ACROSS_SIN


def joins(scene: Scene, o: SceneObject) -> bool:
    """True if a vehicle alongside or just ahead crawls into the ego's lane from the side."""
    gap = o.gap_m if o.gap_m is not None else math.inf
    beside = (o.left_edge_m + o.right_edge_m) / 2
    converges = abs(beside) > JOINS_M and math.sin(o.yaw_rad) * beside < 0.0 and abs(o.yaw_rad) > JOINS_RAD
    near = -scene.ego.length_m - o.length_m < gap < JOINS_AHEAD_M
    return o.kind in MOTOR_VEHICLES and near and converges and MOVING_MPS < o.speed_along_mps < CRAWLS_MPS


def no_gap_to_join(scene: Scene, lead: SceneObject) -> SceneObject | None:
    """Return a vehicle that merges ahead of the ego, if the ego has waited too long to be merely queueing; else
    None.
    """
    crawls = MOVING_MPS < lead.speed_along_mps < CRAWLS_MPS
    let_in_s = LET_IN_S if Claim.WAVED_THROUGH not in scene.claims else WAVED_S
    if not crawls or scene.ego.stopped_for_s < let_in_s:
        return None
    return next((o for o in scene.objects if joins(scene, o)), None)


def goes_first(scene: Scene) -> SceneObject | None:
    """Return a vehicle that will cross the route just ahead or enter it from the side, faster than a crawl; else None.

    Its course is assumed to be steady.
    """
    route = [(0.0, 0.0), *((w.x_m, w.y_m) for w in scene.waypoints if on_route(scene, w))]
    if len(route) < 2:
        return None
    way, along = LineString(route), _way_along(scene)
    for o in scene.objects:
        if not drives(o) or (o.in_path and o.speed_along_mps > MOVING_MPS):
            continue
        comes = along.distance(_course_along(scene, o)) if _keeps_to_road(o) else way.distance(_course(o))
        if comes < YIELD_BESIDE_M:
            return o
    return None


def _course(o: SceneObject) -> LineString:
    """Return its course straight on in the ego frame (m), for a vehicle that crosses the route's road."""
    return LineString([(o.x_m, o.y_m), (o.x_m + o.vx_mps * YIELD_S, o.y_m + o.vy_mps * YIELD_S)])


def _keeps_to_road(o: SceneObject) -> bool:
    """True if a vehicle drives along the route's road, in any lane and direction, and not across it."""
    near = o.gap_m is not None and abs(o.left_edge_m + o.right_edge_m) / 2 < ROAD_HALF_WIDTH_M
    return near and abs(o.speed_across_mps) < ALONG_TAN * abs(o.speed_along_mps)


def _course_along(scene: Scene, o: SceneObject) -> LineString:
    """Return its course along the bends of the road: (from the ego's center along it, left of the route's lane) (m)."""
    # The gap is measured from bumper to bumper: add half of each body.
    s, d = (o.gap_m or 0.0) + (scene.ego.length_m + o.length_m) / 2, (o.left_edge_m + o.right_edge_m) / 2
    return LineString([(s, d), (s + o.speed_along_mps * YIELD_S, d + o.speed_across_mps * YIELD_S)])


def _way_along(scene: Scene) -> LineString:
    """Return the ego's path ahead in the same coordinates, in its present lane."""
    own = next((lane for lane in scene.lanes if lane.id == scene.ego.lane_id), None)
    d = 0.0 if own is not None and own.relation is LaneRelation.EGO else scene.ego.lateral_offset_m
    reach = max(w.distance_m for w in scene.waypoints if on_route(scene, w))
    return LineString([(0.0, d), (reach, d)])


def drives(o: SceneObject) -> bool:
    """True if a vehicle moves in any direction faster than a crawl."""
    return o.kind in VEHICLES and math.hypot(o.vx_mps, o.vy_mps) > CRAWLS_MPS


def on_route(scene: Scene, waypoint: CandidateWaypoint) -> bool:
    """True if a candidate waypoint is in the ego's lane, and near enough to matter for who goes first."""
    return waypoint.lane_id == scene.ego.lane_id and waypoint.distance_m < YIELD_AHEAD_M


def _in_queue_across(scene: Scene, o: SceneObject) -> bool:
    """True if another vehicle that points the same way is close ahead of it."""
    cos, sin = math.cos(o.yaw_rad), math.sin(o.yaw_rad)
    for other in scene.objects:
        ahead, aside = other.x_m - o.x_m, other.y_m - o.y_m
        along, beside = ahead * cos + aside * sin, aside * cos - ahead * sin
        gap = along - (o.length_m + other.length_m) / 2
        same_way = math.cos(other.yaw_rad - o.yaw_rad) > SAME_WAY_COS
        if other.kind in MOTOR_VEHICLES and same_way and abs(beside) < SAME_LANE_M and -1.0 < gap < QUEUE_GAP_M:
            return True
    return False


def _on_foot(o: SceneObject) -> Intent:
    toward = -1.0 if o.left_edge_m + o.right_edge_m > 0 else 1.0
    if o.in_path or o.vy_mps * toward > CROSSING_MPS:
        return Intent.CROSSING
    return Intent.WAITING_TO_CROSS if is_near_path(o) else Intent.UNKNOWN


def _in_queue(scene: Scene, o: SceneObject, limits: WaitLimits) -> bool:
    """True if it has moved recently, or has a light, a stop sign or a vehicle that has moved recently ahead of it."""
    if o.moved_s_ago is not None and o.moved_s_ago < limits.queue_moved_within_s:
        return True
    front = (o.gap_m or 0.0) + o.length_m
    for control in scene.controls:
        held = control.kind is ControlKind.STOP_SIGN or control.state in (LightState.RED, LightState.YELLOW)
        if control.applies is not False and held and front - 2.0 <= control.distance_m < front + 15.0:
            return True
    return any(
        other.id != o.id
        and other.in_path
        and other.kind in MOTOR_VEHICLES
        and other.gap_m is not None
        and front < other.gap_m < front + 12.0
        and other.moved_s_ago is not None
        and other.moved_s_ago < limits.queue_moved_within_s
        for other in scene.objects
    )


def _summary(scene: Scene, participants: tuple[Participant, ...]) -> str:
    parts = [
        f"{p.kind.value} {p.object_id} ({p.intent.value.replace('_', ' ')}, lane {p.lane.value}"
        + (f", {whereabouts(p.distance_m)})" if p.distance_m is not None else ")")
        for p in participants[:6]
    ]
    lights = [
        f"{c.state.value} light {whereabouts(c.distance_m)}"
        for c in scene.controls
        if c.kind is ControlKind.TRAFFIC_LIGHT and c.state is not None and c.applies is not False
    ]
    return "; ".join(lights + parts) or "nothing relevant in sight"
