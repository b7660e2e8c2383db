"""Searches a path from pose to pose in road coordinates, forward and in reverse, clear of all stationary objects.

A lattice search of the axle without steering finds on which side of each object to pass, with the vehicle's turning
radius. Its motion is then smoothed and checked exactly, as the body of `FrenetPath.body`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stucksolver.plan.behaviors.behavior import BehaviorStart, NoPathError
from stucksolver.plan.frenet_path import STEP_M, FrenetPath
from stucksolver.plan.path_lattice import LAYER_M, STRAIGHTENS_M, LatticeMotion, LatticeTask, cheapest_motion
from stucksolver.plan.path_smoothing import smooth
from stucksolver.plan.swept_body import Body, Borders, Obstacles, blocked_offsets
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet import Array, Lane
from stucksolver.scene.frenet_scene import FrenetScene

LEAST_CLEARANCE_M, CLEARANCE_M = 0.32, 0.8
"""Smallest sufficient and desired clearance from stationary objects (m). The first is just above the guard's bound of
0.3 m (`ClearancePolicy`), the second is ours.
"""
LEAST_VULNERABLE_CLEARANCE_M, VULNERABLE_CLEARANCE_M = 1.05, 1.4
"""The same for pedestrians and cyclists (m); the guard's bound is 1 m."""
NEARER_M = 0.05
"""Least decrease of a gap that counts as approaching (m): `ClearancePolicy.nearer_m`."""
RESERVE_M = 0.04
"""Clearance that the lattice keeps in addition (m): for its cells, and for places between its layers. Ours."""
BEYOND_M = 0.05
"""Reach of the body over a border that is allowed (m). The guard allows 0.15 m over the edge of the road. Ours."""
SPAN_M = 60.0
"""Greatest length of a search (m). Ours."""
BACK_M = 8.0
"""Greatest distance to back up that a failure proposes (m). Ours."""
BACK_TRIES = 4
"""Distances to back up that are tried, `STEP_M` apart, from the first that the lattice finds on. Ours."""
SMOOTHINGS = ((0.02, 1.0), (0.3, 1.0), (3.0, 1.0), (0.3, 0.4), (3.0, 0.4), (0.3, 0.0), (3.0, 0.0))
"""Ways to smooth the lattice's motion, tried in order: the weight with which the path keeps to it, and the part of its
clearance beyond the least one that the path keeps. Ours.
"""
SPAN_OF_BEND_M = 3.0
"""Distance over which the curvature of the road is averaged (m): three points of a typical reference line. Ours."""
BEND_SLACK = 1.03
"""Ratio of the curvature that a smooth path may have to that of the turning radius. Ours."""
STRAIGHT_M = 2.0
"""Straight beyond the goal, on which the body still turns parallel to the road (m). Ours."""
ENDS_M = 0.01
"""Distance from the goal's offset below which the path has reached it (m). Ours."""


@dataclass(frozen=True)
class Goal:
    """Where a path ends: at an offset, along the road, between two arc lengths.

    Attributes:
        d_m: Lateral offset (m, left positive).
        latest_s_m: Greatest arc length (m).
        earliest_s_m: Least arc length (m), for a path that ends where it began and passes something in between.
    """

    d_m: float
    latest_s_m: float
    earliest_s_m: float = -np.inf


def search_path(
    view: FrenetScene,
    start: BehaviorStart,
    goal: Goal,
    lanes: tuple[Lane, ...] = (),
    *,
    desired_m: float = CLEARANCE_M,
    reverse: bool = False,
) -> FrenetPath:
    """Return a smooth path from the pose of `start` to `goal` that keeps clear of all stationary objects.

    Nothing bounds its speed yet: see `bounded_speed`.

    Args:
        view: Surroundings in road coordinates; `FrenetScene.backwards` in reverse.
        start: Start, with its exact offset and heading. Its speed bounds the curvature, at the limit of lateral
            acceleration.
        goal: End of the path.
        lanes: Lanes that the body must not leave; the drivable area if there are none.
        desired_m: Clearance from stationary objects that the path keeps where there is room (m).
        reverse: True if the ego backs up. The path then has the headings of the body.

    Raises:
        NoPathError: There is no path. The error names the object that lacks the most clearance, and how far the ego
            must back up for a path.
    """
    names = tuple(lane.strip.id for lane in lanes)
    key = ("search_path", start, goal, names, desired_m, reverse)
    # Plans that differ only in speed share the results of one tick.
    if key not in view.memo:
        try:
            view.memo[key] = _Search(view, start, goal, lanes, desired_m, reverse).path()
        except NoPathError as error:
            view.memo[key] = error
    found: FrenetPath | NoPathError = view.memo[key]
    if isinstance(found, NoPathError):
        raise found.with_traceback(None)
    return found


class _Search:
    """One search, with the body, the borders and the objects in its reach."""

    def __init__(
        self,
        view: FrenetScene,
        start: BehaviorStart,
        goal: Goal,
        lanes: tuple[Lane, ...],
        desired_m: float,
        reverse: bool,
    ) -> None:
        self.view, self.start, self.goal, self.reverse = view, start, goal, reverse
        self.lanes, self.desired_m = lanes, desired_m
        self.body = Body.of(view, reverse)
        self.latest_s = min(goal.latest_s_m, start.s_m + SPAN_M)
        self.borders = _borders(view, start, self.body, lanes)
        self.obstacles = stationary_obstacles(view, start, self.latest_s, desired_m)
        self.road_bend = _road_bend(view)
        limits = view.ego.limits
        self.radius_m = max(limits.min_turn_radius_m, start.speed_mps**2 / limits.max_lateral_acceleration_mps2)

    def path(self) -> FrenetPath:
        """Return the path. See `search_path`."""
        motion = self._motion(0.0)
        path = None if motion is None else self._smooth(motion)
        if path is None:
            raise self._failure(motion)
        return _until_goal(path, self.goal)

    def _smooth(self, motion: LatticeMotion) -> FrenetPath | None:
        """Return the first smooth path that fits; None without one."""
        if not motion.clear:
            return None
        paths = (self._smoothed(motion, keep, part, self.obstacles) for keep, part in SMOOTHINGS)
        return next((path for path in paths if self._fits(path)), None)

    def _motion(self, back_m: float, least_back_m: float = 0.0) -> LatticeMotion | None:
        start_s, start_d = self.body.axle(self.start.s_m, self.start.d_m, self.start.yaw_rad)
        task = LatticeTask(
            self.body,
            start_s,
            start_d,
            float(np.tan(self.start.yaw_rad)),
            self.goal.d_m,
            self.goal.earliest_s_m - self.body.lever_m,
            self.latest_s - self.body.lever_m,
            self.radius_m,
            back_m,
            least_back_m,
        )
        reserve = self.obstacles.with_reserve(RESERVE_M)
        return cheapest_motion(task, self.borders, reserve, self.road_bend)

    def _smoothed(self, motion: LatticeMotion, keep: float, part: float, obstacles: Obstacles) -> FrenetPath:
        """Return the motion as a smooth path of the box center, on which the body keeps clear of the obstacles.

        The smooth line is that of the box center ahead, and that of the axle, which leads, in reverse.
        """
        axle_yaw = np.arctan(np.gradient(motion.d, motion.s))
        axle_yaw[0] = self.start.yaw_rad
        s, d = (motion.s, motion.d) if self.reverse else self.body.center(motion.s, motion.d, axle_yaw)
        stations: Array = s[0] + STEP_M * np.arange(int((s[-1] - s[0] + STRAIGHT_M) / STEP_M) + 1)
        rough = np.interp(stations, s, d)
        rough[stations >= s[-1]] = self.goal.d_m
        line = _SmoothedLine(self.body, self.start, stations, self.reverse)
        bounds = _Bounds(line, rough, self.borders, obstacles, part)
        slope = float(np.tan(self.start.yaw_rad))
        return line.path(smooth(rough, slope, keep, bounds, self._bend_limits(stations)))

    def _bend_limits(self, s: Array) -> tuple[Array, Array]:
        """(stations,): least and greatest curvature of a line relative to the road (1/m)."""
        most, road = 1.0 / self.radius_m, np.interp(s, *self.road_bend)
        return np.minimum(-most - road, 0.0), np.maximum(most - road, 0.0)

    def _lacks(self, path: FrenetPath) -> Array:
        """(objects,): lack of clearance from each object on the path (m); negative where there is more."""
        yaw = path.body(self.start.yaw_rad, self.view.ego.limits.wheelbase_m)
        lacks: Array = (self.obstacles.least - self.obstacles.gaps(self.body, path.s, path.d, yaw)).max(axis=0)
        return lacks

    def _fits(self, path: FrenetPath) -> bool:
        """True if the path keeps its clearances, the turning radius and the borders."""
        if not self.reverse:
            low, high = self._bend_limits(path.s[1:-1])
            bend = np.diff(path.d, 2) / STEP_M**2
            if (bend < BEND_SLACK * low - 1e-3).any() or (bend > BEND_SLACK * high + 1e-3).any():
                return False
        yaw = path.body(self.start.yaw_rad, self.view.ego.limits.wheelbase_m)
        within = self.borders.holds(self.body, path.s, path.d, yaw, BEYOND_M)
        return bool(within.all() and (self._lacks(path) <= 0.0).all())

    def _failure(self, motion: LatticeMotion | None) -> NoPathError:
        """Return the error with the object that lacks the most clearance and the distance to back up."""
        aside_m = abs(self.goal.d_m - self.start.d_m)
        clear = motion is not None and motion.clear

        def find_back_up() -> float | None:
            return self._back_up_m(clear)

        text = f"no room to move by {aside_m:.1f} m"
        if motion is None or not self.obstacles.ids:
            return NoPathError(PlanFailure.NO_ROOM_ASIDE, f"{text} within the lanes", find_back_up=find_back_up)
        # The motion without its objects keeps the turning radius, so that only clearance is missing.
        lacks = self._lacks(self._smoothed(motion, *SMOOTHINGS[1], self.obstacles.some(np.zeros(0, dtype=int))))
        k = int(lacks.argmax())
        name, short_m = self.obstacles.ids[k], max(float(lacks[k]), 0.0)
        kind = self.view.objects[self.view.index_of(name) or 0].kind.value
        return NoPathError(
            PlanFailure.NO_SPACE_TO_PULL_AROUND,
            f"{text}: {kind} {name}, {short_m:.2f} m short",
            object_id=name,
            short_m=short_m,
            find_back_up=find_back_up,
        )

    def _back_up_m(self, clear: bool) -> float | None:
        """Return how far the ego must back up for a path (m); None if that does not help.

        Args:
            clear: True if the lattice has a motion from here, which only cannot be smoothed.
        """
        back = self._motion(BACK_M, LAYER_M if clear else 0.0)
        if back is None or not back.clear:
            return None
        for more in range(BACK_TRIES):
            back_m = back.back_m + more * STEP_M
            yaw_rad = self.start.yaw_rad * float(np.exp(-back_m / STRAIGHTENS_M))
            start = replace(self.start, s_m=self.start.s_m - back_m, yaw_rad=yaw_rad, speed_mps=0.0)
            there = _Search(self.view, start, self.goal, self.lanes, self.desired_m, self.reverse)
            motion = there._motion(0.0)
            if motion is not None and there._smooth(motion) is not None:
                return back_m
        return None


@dataclass(frozen=True)
class _SmoothedLine:
    """Line to smooth, at its stations: that of the box center ahead, that of the axle in reverse."""

    body: Body
    start: BehaviorStart
    s: Array
    reverse: bool

    def yaw(self, offsets: Array) -> Array:
        """(stations,): headings of the body along the line (rad)."""
        if not self.reverse:
            path = FrenetPath(self.s, offsets, offsets)
            return path.body(self.start.yaw_rad, 2 * self.body.lever_m)
        yaw: Array = np.arctan(np.gradient(offsets, STEP_M))
        yaw[0] = self.start.yaw_rad
        return yaw

    @property
    def rider(self) -> Body:
        """The body around the point that follows the line."""
        return self.body if self.reverse else replace(self.body, lever_m=0.0)

    def path(self, offsets: Array) -> FrenetPath:
        """Return the path of the box center."""
        if not self.reverse:
            return FrenetPath(self.s, offsets, np.full(len(self.s), np.inf))
        yaw = self.yaw(offsets)
        center_s, center_d = self.body.center(self.s, offsets, yaw)
        count = max(int((center_s[-1] - self.start.s_m) / STEP_M + 1e-6), 1) + 1
        s: Array = self.start.s_m + STEP_M * np.arange(count)
        d, along = np.interp(s, center_s, center_d), np.interp(s, center_s, yaw)
        return FrenetPath(s, d, np.full(count, np.inf), yaw=along)


class _Bounds:
    """Bounds on the offsets of a line for the body's headings along it, on the rough line's side of each object."""

    def __init__(self, line: _SmoothedLine, rough: Array, borders: Borders, obstacles: Obstacles, part: float) -> None:
        self._line, self._rough, self._borders, self._obstacles = line, rough, borders, obstacles
        yaw = line.yaw(rough)
        s, d = line.rider.center(line.s, rough, yaw)
        gaps = obstacles.gaps(line.body, s, d, yaw)
        kept = np.minimum(gaps.min(axis=0, initial=np.inf), obstacles.desired)
        least = obstacles.least + RESERVE_M / 2
        self._clearance = least + part * np.maximum(kept - RESERVE_M - least, 0.0)

    def __call__(self, offsets: Array) -> tuple[Array, Array]:
        """Return the least and greatest offsets (stations,) (m) for these offsets."""
        yaw, rider = self._line.yaw(offsets), self._line.rider
        low, high = self._borders.offsets(rider, self._line.s, yaw)
        if self._obstacles.ids:
            below, above = blocked_offsets(rider, self._line.s[:, None], yaw[:, None], self._obstacles, self._clearance)
            blocks = below <= above
            left = self._rough[:, None] > (below + above) / 2
            low = np.maximum(low, np.where(blocks & left, above, -np.inf).max(axis=1))
            high = np.minimum(high, np.where(blocks & ~left, below, np.inf).min(axis=1))
        return np.minimum(low, high), np.maximum(low, high)


def stationary_obstacles(
    view: FrenetScene, start: BehaviorStart, until_s: float, desired_m: float = CLEARANCE_M
) -> Obstacles:
    """Return the stationary objects near a path with the clearances to keep from them.

    The ego may stay as near to an object as it is at the start, but not come nearer.

    Args:
        view: Surroundings in road coordinates.
        start: Start of the path.
        until_s: Arc length of the path's end (m).
        desired_m: Clearance beyond which more room makes no path better (m); for people it is at least their own.
    """
    reach_m = view.ego.length_m + BACK_M
    near = (view.s + view.along > start.s_m - reach_m) & (view.s - view.along < until_s + view.ego.length_m)
    which = np.flatnonzero(~view.moving & near)
    vulnerable = view.vulnerable[which]
    least = np.where(vulnerable, LEAST_VULNERABLE_CLEARANCE_M, LEAST_CLEARANCE_M)
    desired = np.where(vulnerable, max(VULNERABLE_CLEARANCE_M, desired_m), desired_m)
    ids = tuple(view.objects[int(i)].id for i in which)
    places = view.s[which], view.d[which], view.yaw[which], view.half_length[which], view.half_width[which]
    obstacles = Obstacles(ids, *places, least, desired)
    here = np.array([start.s_m]), np.array([start.d_m]), np.array([start.yaw_rad])
    gaps = obstacles.gaps(Body.of(view), *here)[0]
    return replace(obstacles, least=np.minimum(least, gaps - NEARER_M))


def _borders(view: FrenetScene, start: BehaviorStart, body: Body, lanes: tuple[Lane, ...]) -> Borders:
    """Return the borders for the body: as far out as it is at the start, and otherwise within the lanes."""
    right, left = view.frame.drivable
    if lanes:
        right = np.min([np.interp(view.frame.s, lane.s, lane.right) for lane in lanes], axis=0)
        left = np.max([np.interp(view.frame.s, lane.s, lane.left) for lane in lanes], axis=0)
    reach = float(body.reach(np.array([start.yaw_rad]))[0])
    over_left = start.d_m + reach - float(np.interp(start.s_m, view.frame.s, left))
    over_right = float(np.interp(start.s_m, view.frame.s, right)) - start.d_m + reach
    return Borders(view.frame.s, right, left, max(over_left + BEYOND_M, over_right + BEYOND_M, BEYOND_M))


def _road_bend(view: FrenetScene) -> Array:
    """(2, stations): arc lengths (m) and curvatures of the road there (1/m, left positive)."""
    s = view.frame.s
    half_m = SPAN_OF_BEND_M / 2
    ahead, behind = np.interp(s + half_m, s, view.frame.headings), np.interp(s - half_m, s, view.frame.headings)
    span_m = np.minimum(s + half_m, s[-1]) - np.maximum(s - half_m, s[0])
    return np.stack([s, (ahead - behind) / np.maximum(span_m, 1e-3)])


def _until_goal(path: FrenetPath, goal: Goal) -> FrenetPath:
    """Return the path up to the station from which it stays at the goal's offset."""
    away = np.flatnonzero((np.abs(path.d - goal.d_m) > ENDS_M) | (path.s < goal.earliest_s_m - STEP_M))
    count = min(int(away[-1]) + 3 if len(away) else 2, len(path.s))
    d = path.d[:count].copy()
    d[-1] = goal.d_m
    yaw = None if path.yaw is None else path.yaw[:count]
    return FrenetPath(path.s[:count], d, path.speed[:count], yaw=yaw)
