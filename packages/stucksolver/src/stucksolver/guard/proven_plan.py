"""Plan laid out as one path, with the checks that its behaviors name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stucksolver.guard import back_up, lane_entry, marking, oncoming_lane, passable_obstacles, traffic_rules
from stucksolver.guard import path_checks as checks
from stucksolver.guard.adjacent_traffic import from_behind
from stucksolver.guard.context import CheckContext
from stucksolver.guard.policy import NOBODY, Approvals, GuardPolicy
from stucksolver.guard.sight_distance import check_sight_distance
from stucksolver.guard.verdict import RejectReason
from stucksolver.plan.behaviors import Behavior, Check
from stucksolver.plan.frenet_path import FrenetPath
from stucksolver.scene.frenet import Mask
from stucksolver.scene.frenet_scene import FrenetScene

CHECKS: dict[Check, Callable[[CheckContext], list[RejectReason]]] = {
    Check.COLLISION: lambda case: checks.collision(case) + from_behind(case) + check_sight_distance(case),
    Check.DRIVABLE_AREA: checks.drivable_area,
    Check.SPEED: checks.speed,
    Check.STOP_LINE: checks.stop_line,
    Check.ROADSIDE: checks.roadside,
    Check.WITHIN_LANE: traffic_rules.within_lane,
    Check.CREEP_SPEED: traffic_rules.creep_speed,
    Check.AUTHORITY: lambda case: (
        traffic_rules.authority(case) + traffic_rules.off_rails(case) + traffic_rules.full_exit(case)
    ),
    Check.OFF_ROUTE: traffic_rules.off_route,
    Check.STOPPING_PLACE: traffic_rules.stopping_place,
    Check.NO_WORSE_PLACE: traffic_rules.no_worse_place,
    Check.SEEN_FREE: back_up.check_lane_visible,
    Check.PASSABLE: passable_obstacles.passable,
    Check.PATIENCE: passable_obstacles.check_wait_elapsed,
    Check.MARKING: marking.marking,
    Check.ONCOMING: oncoming_lane.oncoming,
    Check.LANE_ENTRY: lane_entry.lane_entry,
}
SETTLED = frozenset({Check.CREEP_SPEED, Check.OFF_ROUTE, Check.WITHIN_LANE})
"""Checks of the path alone: their result is final at acceptance."""


@dataclass(frozen=True)
class ProvenPlan:
    """Behaviors laid out as one path. `Guard.accept` returns it only for an accepted plan.

    Attributes:
        behaviors: Behaviors, in order.
        path: Path of the plan. A reverse path is in the frame of `FrenetScene.backwards`.
        ends_s: Arc length at which each behavior ends (m).
        no_stop: (stations,): True where the ego is committed. A stop would end where no vehicle should stop, and the
            safe option is to finish, which was proven.
        expected_s: Expected duration (s).
        guided: True if the passenger's guidance requests the plan.
        approvals: Approvals by people.
        start_mps: Speed at the start (m/s).
        stopped_at_s: Arc lengths of the stop lines at which the ego had stopped at the start (m).
    """

    behaviors: tuple[Behavior, ...]
    path: FrenetPath
    ends_s: tuple[float, ...]
    no_stop: Mask
    expected_s: float
    guided: bool
    approvals: Approvals = NOBODY
    start_mps: float = 0.0
    stopped_at_s: tuple[float, ...] = ()

    @property
    def reverse(self) -> bool:
        """True if the plan backs up."""
        return self.behaviors[0].reverse

    @cached_property
    def checks(self) -> tuple[Check, ...]:
        """Checks that the behaviors name, in the guard's order."""
        return tuple(check for check in CHECKS if any(check in b.checks for b in self.behaviors))

    @cached_property
    def checks_on_tick(self) -> tuple[Check, ...]:
        """Checks whose result can change while the plan runs."""
        return tuple(check for check in self.checks if check not in SETTLED)

    def context(self, view: FrenetScene, path: FrenetPath, policy: GuardPolicy) -> CheckContext:
        """Return the context of a check of the plan, or of the rest of it.

        Args:
            view: Surroundings in road coordinates, as the plan faces them.
            path: Path of the plan from the ego's present pose.
            policy: Policy of the guard.
        """
        return CheckContext(
            view,
            path,
            policy,
            self.guided,
            approvals=self.approvals,
            stopped_at_s=self.stopped_at_s,
            commit_s=self.commit_s(view.ego_s),
            reverse=self.reverse,
            began_s=float(self.path.s[0]),
        )

    def commit_s(self, s: float) -> float:
        """Return the arc length of the next commit point at or after `s` (m), rounded to the safe side.

        It is `s` if the ego is committed there, and the path's end if no commit point is left.
        """
        ahead = np.flatnonzero(self.no_stop & (self.path.s >= s))
        if self.committed(s):
            return s
        return max(float(self.path.s[max(int(ahead[0]) - 1, 0)]), s) if len(ahead) else self.path.end_s

    def committed(self, s: float) -> bool:
        """True if the ego is committed at the station before or after an arc length (m)."""
        after = int(np.searchsorted(self.path.s, s, side="right"))
        return bool(self.no_stop[max(after - 1, 0) : after + 1].any())
