"""Takes another road if this one is closed from kerb to kerb."""

from __future__ import annotations

import math

from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import ReplanRoute
from stucksolver.reasoners.rules.pass_options import Way
from stucksolver.reasoners.rules.recent_attempts import has_been_tried
from stucksolver.scene import CandidateWaypoint, LaneKind, LaneRelation, ObjectKind, Scene, SceneObject

CLOSING = frozenset({ObjectKind.BARRIER, ObjectKind.CONE})
"""Objects that close a road."""
LIKE_A_BARRIER = frozenset({ObjectKind.UNKNOWN, ObjectKind.PROP, ObjectKind.DEBRIS})
"""Objects that sensors may take a barrier for, if they have stood all the time."""
STOOD_S = 10.0
"""How long such an object must have stood (s): as long as a vehicle that may be waiting (`WaitLimits`)."""
LEAST_ACROSS_M = 0.8
"""How wide it, or a row in the only lane, must be across the road (m): two thirds of a barrier, more than a cone."""
GAP_M = 1.5
"""A gap between two objects of a row that is too narrow for any car (m)."""
SIDE_M = 0.9
"""Free width that such a row may leave at either edge of the road (m)."""
ABREAST_M = 1.0
"""How far behind the vehicle's center another way may start for the vehicle to turn into it still (m)."""


def detour(scene: Scene, lead: SceneObject) -> Way | None:
    """Return a plan to take the shortest other route to the destination; None if there is none.

    A passenger who speaks wants to get past, and is not answered with another route.
    """
    if (
        not scene.offers("replan")
        or scene.guidance is not None
        or has_been_tried(scene, "replan")
        or not is_closed(scene, lead)
    ):
        return None
    start = min(detour_starts(scene), key=lambda w: w.route_length_m or math.inf, default=None)
    if start is None:
        return None
    plan = RecoveryPlan(behaviors=(ReplanRoute(route_start=start.id),))
    return plan, (None, f"the road is closed from kerb to kerb by {lead.kind.value} {lead.id}: take another road")


def is_closed(scene: Scene, lead: SceneObject) -> bool:
    """True if `lead` and others like it form a row without a gap across all known lanes.

    Inside a junction only the ego's lane is known. A row may be seen there at an angle and only in part, so it closes
    the lane if it leaves no car a gap on either side.
    """
    row = _row(scene, lead)
    if not any(o.kind in CLOSING for o in row):
        return False
    road_left, road_right = _edges_m(scene)
    left, right = max(o.left_edge_m for o in row), min(o.right_edge_m for o in row)
    one_lane = all(lane.relation is LaneRelation.EGO for lane in scene.lanes)
    side_m = GAP_M if one_lane and left - right >= LEAST_ACROSS_M else SIDE_M
    return left > road_left - side_m and right < road_right + side_m


def _row(scene: Scene, lead: SceneObject) -> list[SceneObject]:
    """Return the row that closes the road, `lead` included: no car fits between one and the next."""
    others = [o for o in scene.objects if _closes(o) and o.id != lead.id]
    row = [lead] if _closes(lead) else []
    for member in row:
        row += [o for o in others if _gap_m(member, o) < GAP_M]
        others = [o for o in others if o not in row]
    return row


def _closes(o: SceneObject) -> bool:
    """True for barriers and cones, and for what sensors have long seen standing and cannot name as a vehicle.

    A person who stands still would count as well, but nobody is driven at: the vehicle takes another road.
    """
    if o.kind in CLOSING:
        return True
    stood = (o.stationary_s or 0.0) >= STOOD_S
    across_m = o.left_edge_m - o.right_edge_m
    return bool(o.position_sd_m) and o.kind in LIKE_A_BARRIER and stood and across_m >= LEAST_ACROSS_M


def _gap_m(first: SceneObject, second: SceneObject) -> float:
    """Return a lower bound of the gap between two objects, whatever their orientation (m)."""
    apart = math.hypot(first.x_m - second.x_m, first.y_m - second.y_m)
    return apart - max(first.length_m, first.width_m) / 2 - max(second.length_m, second.width_m) / 2


def _edges_m(scene: Scene) -> tuple[float, float]:
    """Return the left and right edge of the known lanes, from the center of the ego's lane (m, left positive)."""
    widths = dict.fromkeys(LaneRelation, 0.0)
    for lane in scene.lanes:
        if lane.kind is LaneKind.DRIVING:
            widths[lane.relation] += lane.width_m
    half = widths[LaneRelation.EGO] / 2
    return half + widths[LaneRelation.LEFT] + widths[LaneRelation.ONCOMING], -half - widths[LaneRelation.RIGHT]


def detour_starts(scene: Scene) -> list[CandidateWaypoint]:
    """Return the candidate waypoints ahead or abreast, on other roads, from which the destination can be reached."""
    known = {lane.id for lane in scene.lanes}
    return [
        w
        for w in scene.waypoints
        if w.reaches_destination and w.route_length_m and w.lane_id not in known and w.x_m >= -ABREAST_M
    ]
