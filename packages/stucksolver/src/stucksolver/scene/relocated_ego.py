"""Surroundings after a move of the ego: what it will find at another place, as far as that is known now."""

from __future__ import annotations

import numpy as np

from stucksolver.scene.frenet import Array, Mask
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.surroundings import EgoState, LaneSight

OCCLUDES_M = 2.0
"""Height from which an object occludes the road for a sensor on the roof (m). Ours."""
SAMPLED_M = 4.0
"""Distance between two samples of a lane (m). Ours."""
DIFFERS_M = 8.0
"""If an estimate at the present pose exceeds the sight distance there by more, lower objects occlude as well (m)."""


class RelocatedEgo:
    """Surroundings of a tick for an ego that has stopped at other places.

    Stationary objects stay. Moving ones are left out: where they will be is not known. Sight distances are estimated
    from straight lines of sight, at most as far as the farthest sight distance now.

    Args:
        view: Present surroundings in road coordinates.
    """

    def __init__(self, view: FrenetScene) -> None:
        self._view = view
        seen = view.surroundings
        self._staying = tuple(o for o, moves in zip(seen.objects, view.moving, strict=True) if not moves)
        still = [(o.x_m, o.y_m, o.yaw_rad, o.length_m / 2, o.width_m / 2, o.height_m) for o in self._staying]
        self._boxes: Array = np.array(still).reshape(-1, 6)
        self._reach_m = max((max(entry.ahead_m, entry.behind_m) for entry in seen.sight), default=0.0)
        known = {entry.lane_id: entry for entry in seen.sight}
        self._lanes = tuple(lane for lane in view.frame.lanes if lane.strip.id in known)
        pairs = [(known[lane.strip.id].ahead_m, known[lane.strip.id].behind_m) for lane in self._lanes]
        now: Array = np.array(pairs).reshape(-1, 2)
        tall: Mask = self._boxes[:, 5] > OCCLUDES_M
        estimated, _ = self._visible_m(seen.ego, view.ego_s, tall)
        self._low_occludes = bool((estimated > now + DIFFERS_M).any())
        self._tall = tall
        self._beyond_m: Array = np.maximum(now - estimated, 0.0)
        """(lanes, 2): visible length of each lane beyond the known road, ahead and behind (m)."""

    def at(self, s_m: float, d_m: float, yaw_rad: float, after_s: float) -> FrenetScene:
        """Return the surroundings there.

        Args:
            s_m: Arc length of the ego's center (m).
            d_m: Lateral offset of the ego's center (m, left positive).
            yaw_rad: Heading relative to the road (rad).
            after_s: Time until then (s): stationary objects have stood that much longer.
        """
        view, seen = self._view, self._view.surroundings
        x, y, road_rad = view.frame.to_local(np.array([s_m]), np.array([d_m]))
        pose = {"x_m": float(x[0]), "y_m": float(y[0]), "yaw_rad": float(road_rad[0]) + yaw_rad, "speed_mps": 0.0}
        ego = seen.ego.model_copy(update=pose)
        staying = tuple(o.model_copy(update={"stationary_s": (o.stationary_s or 0.0) + after_s}) for o in self._staying)
        driven_m = s_m - view.ego_s
        controls = tuple(c.model_copy(update={"distance_m": c.distance_m - driven_m}) for c in seen.controls)
        which: Mask = np.ones(len(self._boxes), dtype=bool) if self._low_occludes else self._tall
        lengths, is_open = self._visible_m(ego, s_m, which)
        lengths = lengths + np.where(is_open, self._beyond_m, 0.0)
        sight = tuple(
            LaneSight(lane_id=lane.strip.id, ahead_m=float(ahead), behind_m=float(behind))
            for lane, (ahead, behind) in zip(self._lanes, lengths, strict=True)
        )
        moved = {"ego": ego, "objects": staying, "controls": controls, "sight": sight}
        return FrenetScene(seen.model_copy(update=moved))

    def without_traffic(self) -> FrenetScene:
        """Return the present surroundings without the moving objects."""
        return FrenetScene(self._view.surroundings.model_copy(update={"objects": self._staying}))

    def _visible_m(self, ego: EgoState, s_m: float, which: Mask) -> tuple[Array, Mask]:
        """(lanes, 2), twice: visible length of the lanes ahead and behind of a pose (m); True without occlusion."""
        result = np.zeros((len(self._lanes), 2))
        is_open = np.ones((len(self._lanes), 2), dtype=bool)
        boxes = self._boxes[which]
        for k, lane in enumerate(self._lanes):
            ahead_m = min(lane.end_m, s_m + self._reach_m) - s_m
            behind_m = s_m - max(lane.start_m, s_m - self._reach_m)
            for side, (sign, length_m) in enumerate(((1.0, ahead_m), (-1.0, behind_m))):
                if length_m <= 0.0:
                    continue
                away: Array = np.append(np.arange(0.0, length_m, SAMPLED_M), length_m)
                stations = s_m + sign * away
                x, y, _ = self._view.frame.to_local(stations, np.interp(stations, lane.s, lane.center))
                # The first sample is beside the ego itself.
                hidden = np.flatnonzero(_crosses(boxes, ego.x_m, ego.y_m, x[1:], y[1:]))
                result[k, side] = away[int(hidden[0])] if len(hidden) else away[-1]
                is_open[k, side] = not len(hidden)
        return result, is_open


def _crosses(boxes: Array, from_x: float, from_y: float, x: Array, y: Array) -> Mask:
    """(points,): True if the straight line from a point to each of these crosses any of the boxes.

    Args:
        boxes: (boxes, 6): center (m), heading (rad), half length, half width and height (m).
        from_x: Start of the lines (m).
        from_y: The same across (m).
        x: (points,): ends of the lines (m).
        y: The same across (m).
    """
    cos, sin = np.cos(boxes[:, 2]), np.sin(boxes[:, 2])
    dx, dy = from_x - boxes[:, 0], from_y - boxes[:, 1]
    ends_x, ends_y = x[:, None] - boxes[:, 0], y[:, None] - boxes[:, 1]
    enters, leaves = np.full(ends_x.shape, -np.inf), np.full(ends_x.shape, np.inf)
    for start, end, half in (
        (dx * cos + dy * sin, ends_x * cos + ends_y * sin, boxes[:, 3]),
        (dy * cos - dx * sin, ends_y * cos - ends_x * sin, boxes[:, 4]),
    ):
        step = end - start
        step = np.where(np.abs(step) < 1e-9, 1e-9, step)
        first, second = (-half - start) / step, (half - start) / step
        enters = np.maximum(enters, np.minimum(first, second))
        leaves = np.minimum(leaves, np.maximum(first, second))
    crossed: Mask = np.any((enters < leaves) & (leaves > 0.0) & (enters < 1.0), axis=1)
    return crossed
