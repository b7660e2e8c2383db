"""Context of one check: the path of a plan, rolled out from the present state of the ego."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stucksolver.guard.policy import NOBODY, Approvals, GuardPolicy
from stucksolver.plan.frenet_path import FrenetPath
from stucksolver.plan.speed_profile import SpeedProfile, rollout, slow_launch
from stucksolver.scene.frenet import Array, Lane, Mask
from stucksolver.scene.frenet_scene import SURE_SDS, FrenetScene
from stucksolver.scene.road import LaneDirection, LaneKind, ZoneKind


@dataclass(frozen=True)
class CheckContext:
    """Plan with two speed hypotheses: the ego as fast as comfort allows, and a sluggish one.

    Attributes:
        view: Surroundings in road coordinates.
        path: Path of the plan.
        policy: Policy of the guard.
        guided: True if the passenger's guidance requests the plan.
        running: True if the plan is already running, so that the guard also checks the remaining options.
        approvals: Approvals by people.
        stopped_at_s: Arc lengths of the stop lines at which the ego had stopped when the plan began (m).
        error_m: Lateral distance of the ego from the proven path (m, left positive).
        error_rad: Heading error against the proven path (rad, left positive).
        commit_s: Arc length up to which the plan is checked again on every tick and may end in a stop (m). None if
            everything must be certain now.
        sets_off: True if the ego has stopped for others before a junction, and the check decides on setting off.
        reverse: True if the plan backs up. `view` and `path` are then in the frame of `FrenetScene.backwards`.
        began_s: Arc length at which the plan begins, or began if it is running (m); None for the first one of `path`.
    """

    view: FrenetScene
    path: FrenetPath
    policy: GuardPolicy
    guided: bool = False
    running: bool = False
    approvals: Approvals = NOBODY
    stopped_at_s: tuple[float, ...] = ()
    error_m: float = 0.0
    error_rad: float = 0.0
    commit_s: float | None = None
    sets_off: bool = False
    reverse: bool = False
    began_s: float | None = None

    @cached_property
    def quick(self) -> SpeedProfile:
        """Profile of the path at the vehicle's comfortable acceleration and braking."""
        limits = self.view.ego.limits
        return rollout(
            self.path, self.view.ego.speed_mps, limits.comfort_acceleration_mps2, limits.comfort_braking_mps2
        )

    @cached_property
    def slow(self) -> SpeedProfile:
        """Profile of the path for a vehicle that starts slowly, with the policy's parameters."""
        policy, ego = self.policy.prediction, self.view.ego
        return slow_launch(self.path, ego.speed_mps, ego.limits, policy.sluggish_speed, policy.sluggish_acceleration)

    @cached_property
    def heading(self) -> Array:
        """(stations,): heading of the body relative to the road (rad)."""
        return self.path.heading() if self.path.yaw is None else self.path.yaw

    @cached_property
    def reach(self) -> Array:
        """(stations,): half extent of the body across the road (m), enlarged by the uncertainty of localization."""
        half_length, half_width = self.view.ego.length_m / 2, self.view.ego.width_m / 2
        reach: Array = half_width * np.abs(np.cos(self.heading)) + half_length * np.abs(np.sin(self.heading))
        return reach + SURE_SDS * (self.view.ego.position_sd_m or 0.0)

    @cached_property
    def traffic(self) -> Mask:
        """(objects,): True for objects that move by themselves.

        A tracker may report a velocity for a barrier or a bin. Above walking pace its class is wrong rather than its
        velocity, so it counts.
        """
        result: Mask = self.view.moving | (self.view.speed > self.policy.speeds.creep_mps)
        return result

    def uncertainty_m(self, i: int) -> float:
        """Return how much nearer across the road an object may be than detected, as both poses are uncertain (m)."""
        return float(self.view.uncertainty_m[i]) + SURE_SDS * (self.view.ego.position_sd_m or 0.0)

    def room_m(self, i: int) -> float:
        """Return the gap that an object needs beside the ego (m), in addition to the uncertainty in its box.

        From the most likely position of the object, the gap is that of `EntryPolicy` or the uncertainty, whichever is
        more. With the sum of both, an ego that waits beside a flow at that gap would count as in the path of the flow.
        """
        return max(self.policy.entry.beside_m - float(self.view.uncertainty_m[i]), 0.0)

    def inside(self, lane: Lane) -> Mask:
        """(stations,): True where the body reaches into a lane by more than a few centimeters."""
        cached = self._inside.get(id(lane))
        if cached is None:
            cached = self._inside[id(lane)] = self._reaching_into(lane)
        return cached

    @cached_property
    def _inside(self) -> dict[int, Mask]:
        return {}

    def _reaching_into(self, lane: Lane) -> Mask:
        right = np.interp(self.path.s, lane.s, lane.right)
        left = np.interp(self.path.s, lane.s, lane.left)
        least = self.policy.lanes.reaches_in_m
        touches: Mask = (self.path.d + self.reach > right + least) & (self.path.d - self.reach < left - least)
        return touches

    def entries(self, lane: Lane) -> Array:
        """(entries,): indices of the stations at which the body enters a lane from outside."""
        inside = self.inside(lane)
        return np.flatnonzero(inside[1:] & ~inside[:-1]) + 1

    def first_entries(self, lane: Lane) -> Array:
        """(found,): indices of the stations inside a lane of `path.enters`; the first one is the entry.

        The lane in which the path begins counts as entered. So does, while the plan runs, a lane that the body is
        already in. For those only later entries from outside are returned.
        """
        if lane is self.start_lane or (self.running and self.inside(lane)[0]):
            return self.entries(lane)
        return np.flatnonzero(self.inside(lane))

    @cached_property
    def in_oncoming_lane(self) -> bool:
        """True if the body reaches into a lane of oncoming traffic now."""
        return any(self.inside(lane)[0] for lane in self.oncoming_lanes(float(self.path.s[0])))

    def oncoming_lanes(self, until_s: float) -> Iterator[Lane]:
        """Yield the lanes of oncoming traffic that cover the road from here to an arc length (m)."""
        here = float(self.path.s[0])
        for lane in self.view.frame.lanes:
            is_opposite = lane.strip.direction is LaneDirection.OPPOSITE
            if is_opposite and lane.strip.kind is LaneKind.DRIVING and lane.covers(here, until_s):
                yield lane

    def on_rails(self, until_s: float) -> bool:
        """True if the ego's center or that arc length (m) is on a level crossing."""
        here = float(self.path.s[0])
        return any(self.view.zone_at(s, ZoneKind.LEVEL_CROSSING) is not None for s in (here, until_s))

    @property
    def start_s(self) -> float:
        """Arc length at which the plan began or begins (m)."""
        return float(self.path.s[0]) if self.began_s is None else self.began_s

    @cached_property
    def start_lane(self) -> Lane | None:
        """Lane in which the path begins, if any."""
        return self.view.frame.lane_at(float(self.path.s[0]), float(self.path.d[0]))
