"""Predicts the ego's drive through a junction if it starts now, and its conflicts with other traffic.

The frame is CARLA's world frame (m, rad, s).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from stucksolver.scene.boxes import separation
from stucksolver_carla.drivers.behavior.conflict_paths import ConflictPath
from stucksolver_carla.drivers.behavior.conflicting_traffic import MIN_MPS, ConflictingVehicle
from stucksolver_carla.drivers.behavior.path import Array, Path
from stucksolver_carla.drivers.behavior.profiles import DriverProfile, toward_speed
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel

STEP_S = 0.1
"""Step of the rollout (s). Ours."""
HORIZON_S = 9.0
"""Horizon of the rollout (s). Ours."""
JOINED_S = 4.0
"""Time after joining a flow from which no follower has to brake for the ego (s). Ours."""
LATE_PASS_S = 0.5
"""Maximum delay with which an ego that has started lets vehicles pass without aborting (s). Sensor mode only.

The ego is then early, and does not give up its gap: in a flow the next gap would be too short. Ours."""
_TIME_SHARE = 0.8
"""Share of the predicted time in which the ego may arrive. Ours."""
_MARGIN_M = 0.3
"""Clearance at the ego's sides (m). Ours."""


class Margin(NamedTuple):
    """Required gap before and behind other vehicles: a constant part (m) and a part that grows with their speed (s)."""

    before_m: float
    before_s: float
    behind_m: float
    behind_s: float


class LeadVehicle(NamedTuple):
    """A vehicle on a joining path, projected on the route: bumper gap (m, negative alongside), speed (m/s)."""

    gap_m: float
    speed: float


class PredictedConflict(NamedTuple):
    """The conflicts of a rollout."""

    met: tuple[ConflictPath, ...]
    """The paths on which the ego would come too close to a vehicle."""
    passing: frozenset[int]
    """Ids of vehicles that leave the ego's path in time."""
    leader: LeadVehicle | None
    """The vehicle behind which the ego would join the flow; None without one."""
    pass_soon: bool = False
    """True if all conflicting vehicles will have passed when the ego arrives a little later; see `LATE_PASS_S`."""


def can_stop(speed: float, room: float, deceleration: float) -> bool:
    """Return True if a stop from `speed` (m/s) with `deceleration` (m/s²) needs no more than `room` (m)."""
    return room >= 0.0 and speed * speed <= 2.0 * deceleration * room


class EgoRollout:
    """The predicted positions of the ego if it starts now."""

    def __init__(
        self,
        line: Path,
        s: Array,
        model: VehicleModel,
        slips: bool = False,
        joined_s: float = JOINED_S,
        followers: bool = True,
    ) -> None:
        """Create the rollout.

        Args:
            line: The route's line.
            s: Arc lengths of the ego's center on it, one per step (m).
            model: The ego's box.
            slips: True to model the angle between the body and the motion of its center, which matters on a tight arc.
            joined_s: See `JOINED_S`.
            followers: True if vehicles that follow on the common path count as lead vehicles too. They do if the ego
                has joined with a short gap.
        """
        self._joined_s, self._followers = joined_s, followers
        self._s = s
        self._t = STEP_S * np.arange(len(s))
        self._x, self._y, self._yaw = line.at(s)
        if slips:
            sine = model.rear_axle * np.interp(s, line.s, line.curvature)
            self._yaw = self._yaw - np.arcsin(np.clip(sine, -0.8, 0.8))
        self._model = model

    def predict_conflict(
        self, traffic: Sequence[tuple[ConflictPath, ConflictingVehicle]], margin: Margin
    ) -> PredictedConflict:
        """Return the conflicts with other traffic, in which the ego would come nearer than the margin."""
        met, passing, leaders = list[tuple[ConflictPath, int]](), set[int](), list[LeadVehicle]()
        pass_soon = True
        for path, other in traffic:
            is_surely_behind, is_likely_behind = self._passes_before(path, other)
            if not is_surely_behind and self._is_in_conflict(path, other, margin):
                met.append((path, other.actor_id))
                pass_soon &= self._passes_before(path, other, LATE_PASS_S)[1]
            elif not path.joins:
                passing.add(other.actor_id)
            elif is_likely_behind:
                leader = self._leader(path, other)
                if self._followers or leader.gap_m > -2.0 * self._model.half_length:
                    leaders.append(leader)
        clear = passing.difference(actor_id for _, actor_id in met)
        return PredictedConflict(
            tuple(path for path, _ in met), frozenset(clear), min(leaders, default=None), pass_soon
        )

    def _arrival_s(self, path: ConflictPath) -> float:
        """Return the time at which the ego's front reaches the conflict (s)."""
        return float(np.interp(path.route_meets_s - self._model.half_length, self._s, self._t))

    def _passes_before(self, path: ConflictPath, other: ConflictingVehicle, later_s: float = 0.0) -> tuple[bool, bool]:
        """Return (surely, likely) whether the vehicle has passed, or is ahead on the common path, at the ego's arrival.

        `later_s` delays the ego's arrival (s).
        """
        remaining_m = (path.meets_s + 1.0 if path.joins else path.parts_s) - (other.s - other.half_length)
        arrives_s = self._arrival_s(path) + later_s
        return other.speed * _TIME_SHARE * arrives_s > remaining_m, other.speed * arrives_s > remaining_m

    def _leader(self, path: ConflictPath, other: ConflictingVehicle) -> LeadVehicle:
        """Return a vehicle on a joining path as a lead vehicle on the route, at the same distance from the conflict."""
        front = float(self._s[0]) + self._model.half_length
        return LeadVehicle(other.s - other.half_length - path.meets_s - (front - path.route_meets_s), other.speed)

    def _is_in_conflict(self, path: ConflictPath, other: ConflictingVehicle, margin: Margin) -> bool:
        """Return True if the ego would come nearer to the vehicle than the margin inside the conflict."""
        half = self._model.half_length
        arrival_s = self._arrival_s(path)
        end_s = path.route_parts_s + half
        is_in_conflict = (self._s > path.route_meets_s - half) & (
            (self._t < arrival_s + self._joined_s) if path.joins else (self._s < end_s)
        )
        if not is_in_conflict.any():
            return False
        before = margin.before_m + margin.before_s * other.speed
        behind = margin.behind_m + margin.behind_s * other.speed
        t = self._t[is_in_conflict]
        to_bend_s = max(path.inside_s - other.s, 0.0) / max(other.speed, MIN_MPS)
        travel_m = other.speed * np.minimum(t, to_bend_s) + min(other.speed, path.bend_mps) * np.maximum(
            t - to_bend_s, 0.0
        )
        s = other.s + (before - behind) / 2.0 + travel_m
        x, y, yaw = np.interp(s, path.s, path.x), np.interp(s, path.s, path.y), np.interp(s, path.s, path.yaw)
        beyond_m = np.maximum(s - path.s[-1], 0.0)
        x, y = x + beyond_m * np.cos(yaw), y + beyond_m * np.sin(yaw)
        gap = separation(
            (self._x[is_in_conflict], self._y[is_in_conflict], self._yaw[is_in_conflict]),
            (half, self._model.half_width + _MARGIN_M),
            (x, y, yaw),
            (other.half_length + (before + behind) / 2.0, other.half_width),
        )
        return bool((gap <= 0.0).any())


def predict_drive(
    line: Path,
    s: float,
    speed: float,
    top_mps: float,
    profile: DriverProfile,
    bends: float,
    lag_s: float,
    max_acceleration: Callable[[float], float] | None = None,
    horizon_s: float = HORIZON_S,
) -> Array:
    """Return the arc lengths of the ego's center over the horizon without other traffic (m).

    `max_acceleration` returns the vehicle's highest acceleration at a speed (m/s²), if that is below the profile's.
    """
    spacing = float(line.s[1]) if len(line.s) > 1 else 1.0
    bounds, last = line.speed, len(line.speed) - 1
    arc_lengths, lag = [], lag_s if speed < 1.0 else 0.0
    for k in range(round(horizon_s / STEP_S)):
        arc_lengths.append(s)
        bound = bends * float(bounds[min(int((s + 0.4 * speed) / spacing), last)])
        if k * STEP_S >= lag:
            acceleration = toward_speed(speed, min(bound, top_mps), profile)
            speed = max(
                speed
                + STEP_S * (acceleration if max_acceleration is None else min(acceleration, max_acceleration(speed))),
                0.0,
            )
        s += STEP_S * speed
    return np.array(arc_lengths)
