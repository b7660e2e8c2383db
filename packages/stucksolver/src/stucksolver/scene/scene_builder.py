"""Builds the scene for a reasoner from the surroundings that the guard reads, the status and the stack's offers."""

from __future__ import annotations

import numpy as np

from stucksolver.scene.frenet import Array, Lane, wrap_angle
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.objects import VULNERABLE, ObjectKind, TrackedObject
from stucksolver.scene.road import LaneDirection, LaneKind, LineKind, ZoneKind
from stucksolver.scene.scene import (
    AvailableBehavior,
    CameraImage,
    CandidateWaypoint,
    LaneRelation,
    Scene,
    SceneEgo,
    SceneLane,
    SceneObject,
    SceneZone,
)
from stucksolver.scene.signs import ObservedSign
from stucksolver.scene.status import Status

CROSSING_MPS = 0.3
"""Speed across the road above which a pedestrian or an animal counts as crossing (m/s). Ours."""
PATH_MARGIN_M = 0.2
"""Lateral margin within which an object counts as in the ego's path (m), as in `FrenetScene.in_corridor`. Ours."""
RANGE_M = 120.0
"""Distance along the road beyond which objects are left out of the scene (m); the guard still reads them. Ours."""


def build_scene(
    view: FrenetScene,
    status: Status,
    behaviors: tuple[AvailableBehavior, ...],
    *,
    waypoints: tuple[CandidateWaypoint, ...] = (),
    route_command: str | None = None,
    image: CameraImage | None = None,
    signs: tuple[ObservedSign, ...] = (),
) -> Scene:
    """Build the scene with all information that a reasoner may have now, in the ego frame.

    Args:
        view: The surroundings in road coordinates.
        status: The stack's status at this tick.
        behaviors: Behaviors that the stack can perform now.
        waypoints: Positions from which the route can be replanned.
        route_command: Next command of the route, if there is one.
        image: Image of the front camera, if there is one.
        signs: Words that were read on signs.
    """
    lanes = _nearby_lanes(view)
    own = view.ego_lane
    limit = own.strip.speed_limit_mps if own else None
    return Scene(
        time_s=status.time_s,
        frame=view.surroundings.frame,
        ego=_ego(view, status),
        objects=tuple(_object(view, i) for i in np.argsort(np.abs(view.gap)) if abs(view.s[i] - view.ego_s) < RANGE_M),
        controls=view.surroundings.controls,
        signs=signs,
        lanes=tuple(_lane(view, lane, relation) for lane, relation in lanes),
        zones=_zones(view),
        waypoints=waypoints,
        behaviors=behaviors,
        route_command=route_command,
        speed_limit_mps=limit,
        image=image,
    )


def _ego(view: FrenetScene, status: Status) -> SceneEgo:
    end = view.surroundings.road.destination_m
    zone = view.zone_at(view.ego_s, ZoneKind.LEVEL_CROSSING) or view.zone_at(view.ego_s)
    return SceneEgo(
        speed_mps=round(status.speed_mps, 2),
        lane_id=view.ego_lane.strip.id if view.ego_lane else None,
        lateral_offset_m=round(view.ego_d, 2),
        zone=None if zone is None else zone.kind,
        distance_to_destination_m=None if end is None else round(end - view.ego_s, 1),
        at_destination=status.at_destination,
        length_m=view.ego.length_m,
        width_m=view.ego.width_m,
    )


def _zones(view: FrenetScene) -> tuple[SceneZone, ...]:
    """Return the zones on the route that the ego's body has not left, nearest first."""
    front_s, rear_s = view.ego_front_s, view.ego_s - view.ego.length_m / 2
    near = [z for z in view.surroundings.road.zones if z.end_m > rear_s and z.start_m < front_s + RANGE_M]
    return tuple(
        SceneZone(kind=z.kind, start_m=round(z.start_m - front_s, 1), end_m=round(z.end_m - front_s, 1))
        for z in sorted(near, key=lambda z: z.start_m)
    )


def _nearby_lanes(view: FrenetScene) -> list[tuple[Lane, LaneRelation]]:
    """Return the lanes at the ego's arc length with their relation to the route."""
    here = [lane for lane in view.frame.lanes if lane.start_m - 1.0 <= view.ego_s <= lane.end_m + 1.0]
    return [(lane, relation(view, lane)) for lane in here]


def relation(view: FrenetScene, lane: Lane | None) -> LaneRelation:
    """Return the relation of a lane to the route's own lane."""
    if lane is None:
        return LaneRelation.OFF_ROAD
    if lane.strip.kind is not LaneKind.DRIVING:
        return LaneRelation.SHOULDER
    if lane.strip.direction is LaneDirection.OPPOSITE:
        return LaneRelation.ONCOMING
    center = lane.at(view.ego_s)[1]
    if abs(center) < 1.0:
        return LaneRelation.EGO
    return LaneRelation.LEFT if center > 0 else LaneRelation.RIGHT


def _object(view: FrenetScene, i: int) -> SceneObject:
    obj = view.objects[i]
    lane = view.lane_of[i]
    lane_relation = relation(view, lane)
    half = view.ego.width_m / 2
    in_path = bool(abs(view.d[i]) - view.across[i] < half + PATH_MARGIN_M)
    if obj.kind in VULNERABLE and obj.kind is not ObjectKind.BICYCLE and abs(view.vd[i]) > CROSSING_MPS:
        lane_relation = LaneRelation.CROSSING
    moved = _to_ego(view, obj)
    return SceneObject(
        **{**obj.model_dump(), **moved},
        lane=lane_relation,
        lane_id=lane.strip.id if lane else None,
        gap_m=_rounded(view.gap[i]),
        left_edge_m=_rounded(view.d[i] + view.across[i]),
        right_edge_m=_rounded(view.d[i] - view.across[i]),
        speed_along_mps=_rounded(view.vs[i]),
        speed_across_mps=_rounded(view.vd[i]),
        in_path=in_path,
    )


def _to_ego(view: FrenetScene, obj: TrackedObject) -> dict[str, float]:
    """Return pose and velocity of an object in the ego frame."""
    ego = view.ego
    c, n = np.cos(ego.yaw_rad), np.sin(ego.yaw_rad)
    dx, dy = obj.x_m - ego.x_m, obj.y_m - ego.y_m
    yaw: Array = wrap_angle(np.array(obj.yaw_rad - ego.yaw_rad))
    return {
        "x_m": _rounded(dx * c + dy * n),
        "y_m": _rounded(dy * c - dx * n),
        "yaw_rad": round(float(yaw), 3),
        "vx_mps": _rounded(obj.vx_mps * c + obj.vy_mps * n),
        "vy_mps": _rounded(obj.vy_mps * c - obj.vx_mps * n),
    }


def _rounded(value: float) -> float:
    return round(float(value), 2)


def _lane(view: FrenetScene, lane: Lane, lane_relation: LaneRelation) -> SceneLane:
    sight_m = view.sight_ahead_m(lane)
    right, _, left = lane.at(view.ego_s)
    lines = lane.lines(view.ego_s, view.ego_s + 30.0)
    line = LineKind.SOLID if LineKind.SOLID in lines else (lane.strip.line[0] if not lines else min(lines))
    kerb = LineKind.KERB in lines
    ahead, behind = _free(view, lane)
    return SceneLane(
        id=lane.strip.id,
        relation=lane_relation,
        direction=lane.strip.direction,
        kind=lane.strip.kind,
        width_m=_rounded(left - right),
        line=LineKind.KERB if kerb else line,
        may_enter=not kerb and LineKind.SOLID not in lines and lane.strip.kind is LaneKind.DRIVING,
        free_ahead_m=ahead if sight_m > 0 else None,
        free_behind_m=behind if sight_m > 0 else None,
        sight_ahead_m=_rounded(sight_m) if sight_m > 0 else None,
        speed_limit_mps=lane.strip.speed_limit_mps,
    )


def _free(view: FrenetScene, lane: Lane) -> tuple[float, float]:
    """Return the free length ahead of and behind the ego in a lane (m), at most the known extent of the lane."""
    ahead, behind = lane.end_m - view.ego_front_s, view.ego_s - view.ego.length_m / 2 - lane.start_m
    rear = view.ego_s - view.ego.length_m / 2
    for i in range(len(view.objects)):
        right, _, left = lane.at(float(view.s[i]))
        if view.d[i] - view.across[i] > left - 0.1 or view.d[i] + view.across[i] < right + 0.1:
            continue
        if view.s[i] >= view.ego_s:
            ahead = min(ahead, float(view.gap[i]))
        else:
            behind = min(behind, rear - float(view.s[i] + view.along[i]))
    return max(_rounded(ahead), 0.0), max(_rounded(behind), 0.0)
