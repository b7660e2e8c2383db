"""Surroundings after a move of the ego: what it will find at another place, as far as that is known now."""

from __future__ import annotations

import numpy as np

from stucksolver.scene.frenet import Array, Lane
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.objects import TrackedObject
from stucksolver.scene.surroundings import EgoState, LaneSight

OCCLUDES_M = 2.0
"""Height from which an object occludes the road for a sensor on the roof (m). Ours."""
SAMPLED_M = 4.0
"""Distance between two samples of a lane (m). Ours."""
DIFFERS_M = 8.0
"""If an estimate at the present pose exceeds the sight distance there by more, lower objects occlude as well (m)."""
STOPPED_MPS = 0.1
"""Greatest speed of an object that is assumed to stay (m/s), as for `FrenetScene.moving`."""


def relocated(view: FrenetScene, s_m: float, d_m: float, yaw_rad: float, after_s: float) -> FrenetScene:
    """Return the surroundings with the ego stopped at another place.

    Stationary objects stay. Moving ones are left out: where they will be is not known. Sight distances are estimated.

    Args:
        view: Present surroundings in road coordinates.
        s_m: Arc length of the ego's center (m).
        d_m: Lateral offset of the ego's center (m, left positive).
        yaw_rad: Heading relative to the road (rad).
        after_s: Time of the move (s); stationary objects have stood that much longer.
    """
    seen = view.surroundings
    x, y, road_rad = view.frame.to_local(np.array([s_m]), np.array([d_m]))
    pose = {"x_m": float(x[0]), "y_m": float(y[0]), "yaw_rad": float(road_rad[0]) + yaw_rad, "speed_mps": 0.0}
    ego = seen.ego.model_copy(update=pose)
    staying = tuple(
        obj.model_copy(update={"stationary_s": (obj.stationary_s or 0.0) + after_s})
        for obj, moves in zip(seen.objects, view.moving, strict=True)
        if not moves
    )
    driven_m = s_m - view.ego_s
    controls = tuple(c.model_copy(update={"distance_m": c.distance_m - driven_m}) for c in seen.controls)
    sight = _estimated_sight(view, ego, s_m)
    moved = {"ego": ego, "objects": staying, "controls": controls, "sight": sight}
    return FrenetScene(seen.model_copy(update=moved))


def _estimated_sight(view: FrenetScene, ego: EgoState, s_m: float) -> tuple[LaneSight, ...]:
    """Return the sight distances from a new pose: as far as now at most, up to the first stationary object between."""
    seen = view.surroundings
    now = {entry.lane_id: entry for entry in seen.sight}
    reach_m = max((max(entry.ahead_m, entry.behind_m) for entry in seen.sight), default=0.0)
    found = []
    tall = [o for o in seen.objects if o.height_m > OCCLUDES_M and np.hypot(o.vx_mps, o.vy_mps) <= STOPPED_MPS]
    every = [o for o in seen.objects if np.hypot(o.vx_mps, o.vy_mps) <= STOPPED_MPS]
    for lane in view.frame.lanes:
        entry = now.get(lane.strip.id)
        if entry is None:
            continue
        lengths = []
        for towards, length_m in ((+1, entry.ahead_m), (-1, entry.behind_m)):
            here = _visible_m(view, lane, seen.ego, view.ego_s, towards, reach_m, tall)
            occluders = tall if here <= length_m + DIFFERS_M else every
            lengths.append(_visible_m(view, lane, ego, s_m, towards, reach_m, occluders))
        found.append(LaneSight(lane_id=lane.strip.id, ahead_m=lengths[0], behind_m=lengths[1]))
    return tuple(found)


def _visible_m(
    view: FrenetScene, lane: Lane, ego: EgoState, s_m: float, towards: int, reach_m: float, objects: list[TrackedObject]
) -> float:
    """Return how far the center of a lane is visible ahead (+1) or behind (-1) of a pose (m)."""
    end_m = min(lane.end_m, s_m + reach_m) - s_m if towards > 0 else s_m - max(lane.start_m, s_m - reach_m)
    if end_m <= 0.0:
        return 0.0
    away: Array = np.append(np.arange(0.0, end_m, SAMPLED_M), end_m)
    stations = s_m + towards * away
    x, y, _ = view.frame.to_local(stations, np.interp(stations, lane.s, lane.center))
    hidden = np.zeros(len(away), dtype=bool)
    for obj in objects:
        hidden |= _crosses(obj, ego.x_m, ego.y_m, x, y)
    # The first sample is beside the ego itself.
    first = np.flatnonzero(hidden[1:])
    return float(away[int(first[0])] if len(first) else away[-1])


def _crosses(obj: TrackedObject, from_x: float, from_y: float, x: Array, y: Array) -> Array:
    """(points,): True if the straight line from a point to each of these crosses the object's box."""
    cos, sin = np.cos(obj.yaw_rad), np.sin(obj.yaw_rad)
    start = np.array(
        [(from_x - obj.x_m) * cos + (from_y - obj.y_m) * sin, (from_y - obj.y_m) * cos - (from_x - obj.x_m) * sin]
    )
    ends = np.stack([(x - obj.x_m) * cos + (y - obj.y_m) * sin, (y - obj.y_m) * cos - (x - obj.x_m) * sin])
    half = np.array([obj.length_m / 2, obj.width_m / 2])[:, None]
    step = ends - start[:, None]
    step = np.where(np.abs(step) < 1e-9, 1e-9, step)
    near, far = (-half - start[:, None]) / step, (half - start[:, None]) / step
    enters, leaves = np.minimum(near, far).max(axis=0), np.maximum(near, far).min(axis=0)
    crossed: Array = (enters < leaves) & (leaves > 0.0) & (enters < 1.0)
    return crossed
