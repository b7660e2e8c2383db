"""One plan under examination: its path rolled out from where the ego is now."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stucksolver.decision.manoeuvre import Manoeuvre
from stucksolver.decision.rollout import Rollout, rollout, sluggish
from stucksolver.guard.policy import NOBODY, Approvals, GuardPolicy
from stucksolver.scene.frenet import Array, Lane, Mask
from stucksolver.scene.road import LaneDirection, LaneKind, ZoneKind
from stucksolver.scene.view import SURE_SDS, FrenetScene


@dataclass(frozen=True)
class CheckContext:
    """Two speed hypotheses are carried: the ego as quick as comfort allows, and a sluggish one.

    `running`: the plan is under way, so that it is also a question what can still be done. `stopped_at_s`: arc lengths
    of the lines of dark lights and stop signs at which the ego stood when the plan was begun. `error_m`, `error_rad`:
    how far the ego is beside the path that was proven, and turned from it; left positive. `commit_s`: arc length up to
    which the plan is looked at again on every tick, and a stop may end it; None where all must be certain now.
    """

    view: FrenetScene
    path: Manoeuvre
    policy: GuardPolicy
    guided: bool = False
    running: bool = False
    approvals: Approvals = NOBODY
    stopped_at_s: tuple[float, ...] = ()
    error_m: float = 0.0
    error_rad: float = 0.0
    commit_s: float | None = None

    @cached_property
    def quick(self) -> Rollout:
        """The path at the vehicle's comfortable acceleration and braking."""
        limits = self.view.ego.limits
        return rollout(
            self.path, self.view.ego.speed_mps, limits.comfort_acceleration_mps2, limits.comfort_braking_mps2
        )

    @cached_property
    def slow(self) -> Rollout:
        """The path driven by a vehicle that is slow to start, as the policy has it."""
        policy, ego = self.policy.prediction, self.view.ego
        return sluggish(self.path, ego.speed_mps, ego.limits, policy.sluggish_speed, policy.sluggish_acceleration)

    @cached_property
    def heading(self) -> Array:
        """(stations,): of the body, relative to the road, radians."""
        return self.path.heading() if self.path.yaw is None else self.path.yaw

    @cached_property
    def reach(self) -> Array:
        """(stations,): half extent of the ego's body across the road (m), grown by what localisation is not sure of."""
        half_length, half_width = self.view.ego.length_m / 2, self.view.ego.width_m / 2
        reach: Array = half_width * np.abs(np.cos(self.heading)) + half_length * np.abs(np.sin(self.heading))
        return reach + SURE_SDS * (self.view.ego.position_sd_m or 0.0)

    def inside(self, lane: Lane) -> Mask:
        """(stations,): does the body reach into a lane by more than a few centimetres?"""
        known = self._inside.get(id(lane))
        if known is None:
            known = self._inside[id(lane)] = self._reaching_into(lane)
        return known

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
        """(entries,): stations at which the body, until then outside a lane, reaches into it."""
        inside = self.inside(lane)
        return np.flatnonzero(inside[1:] & ~inside[:-1]) + 1

    def first_entries(self, lane: Lane) -> Array:
        """(entries,): the same for a lane of `path.enters`; the very first station where the body reaches into it now.

        While a plan runs, a lane that the body is in has been entered: up to there its commit point held.
        """
        if lane is self.start_lane or (self.running and self.inside(lane)[0]):
            return self.entries(lane)
        return np.flatnonzero(self.inside(lane))

    @cached_property
    def in_oncoming_lane(self) -> bool:
        """Does the body reach into a lane of the oncoming traffic now?"""
        return any(self.inside(lane)[0] for lane in self.oncoming_lanes(float(self.path.s[0])))

    def oncoming_lanes(self, until_s: float) -> Iterator[Lane]:
        """Lanes of the oncoming traffic along the way from here to an arc length."""
        here = float(self.path.s[0])
        for lane in self.view.frame.lanes:
            is_opposite = lane.strip.direction is LaneDirection.OPPOSITE
            if is_opposite and lane.strip.kind is LaneKind.DRIVING and lane.covers(here, until_s):
                yield lane

    def on_rails(self, until_s: float) -> bool:
        """Is the vehicle on a level crossing, or is that arc length on one?"""
        here = float(self.path.s[0])
        return any(self.view.zone_at(s, ZoneKind.LEVEL_CROSSING) is not None for s in (here, until_s))

    @cached_property
    def start_lane(self) -> Lane | None:
        """The lane in which the path begins, if it begins in one."""
        return self.view.frame.lane_at(float(self.path.s[0]), float(self.path.d[0]))
