"""The ego's own drive if it goes now, and whom of the others it would meet.

CARLA's world frame, meters, radians, seconds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from stucksolver.scene.boxes import separation
from stucksolver_carla.drivers.behavior.conflict_paths import ConflictPath
from stucksolver_carla.drivers.behavior.conflicting_traffic import LEAST_MPS, ConflictingVehicle
from stucksolver_carla.drivers.behavior.path import Array, Path
from stucksolver_carla.drivers.behavior.profiles import DriverProfile, toward_speed
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel

STEP_S = 0.1
HORIZON_S = 9.0
JOINED_S = 4.0
"""From this time after the ego has joined a flow, nobody behind has to brake for it."""
LETS_PASS_S = 0.5
"""By sensors, an ego that has set off and is early lets those pass who will be past if it comes later by no more than
this (s). It does not give up its gap for them: in a stream the next one would be too short.
"""
_EARLY = 0.8
"""The ego may need only this share of the predicted time."""
_MARGIN_M = 0.3


class Margin(NamedTuple):
    """What is kept free before and behind the others, in meters and in seconds of their drive."""

    before_m: float
    before_s: float
    behind_m: float
    behind_s: float


class LeadVehicle(NamedTuple):
    """A vehicle on a joining way, as if it were on the route: bumper gap (m, negative abreast), speed (m/s)."""

    gap_m: float
    speed: float


class PredictedConflict(NamedTuple):
    """Whom the ego would meet."""

    met: tuple[ConflictPath, ...]
    """The ways on which it would meet them."""
    passing: frozenset[int]
    leader: LeadVehicle | None
    pass_soon: bool = False
    """True if all of those whom it would meet will be past if it comes a little later; see `LETS_PASS_S`."""


def can_stop(speed: float, room: float, deceleration: float) -> bool:
    """True if there is room (m) to stop from a speed (m/s) with that deceleration (m/s²)."""
    return room >= 0.0 and speed * speed <= 2.0 * deceleration * room


class EgoRollout:
    """The predicted positions of the ego if it goes now."""

    def __init__(
        self,
        line: Path,
        s: Array,
        model: VehicleModel,
        slips: bool = False,
        joined_s: float = JOINED_S,
        followers: bool = True,
    ) -> None:
        """`slips`: in a bend the body points less far round than its center moves, which matters on a tight one.
        `joined_s`: see `JOINED_S`. `followers`: who follows on the common way counts as a leader, too, which it does if
        the ego has joined with little room.
        """
        self._joined_s, self._followers = joined_s, followers
        self._s = s
        self._t = STEP_S * np.arange(len(s))
        self._x, self._y, self._yaw = line.at(s)
        if slips:
            sine = model.rear_axle * np.interp(s, line.s, line.curvature)
            self._yaw = self._yaw - np.arcsin(np.clip(sine, -0.8, 0.8))
        self._model = model

    def judge(self, coming: Sequence[tuple[ConflictPath, ConflictingVehicle]], margin: Margin) -> PredictedConflict:
        """Return whom of the traffic it would meet, or come too near to."""
        met, passing, leaders = list[tuple[ConflictPath, int]](), set[int](), list[LeadVehicle]()
        pass_soon = True
        for way, other in coming:
            surely, likely = self._comes_behind(way, other)
            if not surely and self._meets(way, other, margin):
                met.append((way, other.actor_id))
                pass_soon &= self._comes_behind(way, other, LETS_PASS_S)[1]
            elif not way.joins:
                passing.add(other.actor_id)
            elif likely:
                leader = self._leader(way, other)
                if self._followers or leader.gap_m > -2.0 * self._model.half_length:
                    leaders.append(leader)
        clear = passing.difference(actor_id for _, actor_id in met)
        return PredictedConflict(tuple(way for way, _ in met), frozenset(clear), min(leaders, default=None), pass_soon)

    def _arrives_s(self, way: ConflictPath) -> float:
        """Return when its front reaches the place where the ways meet (s)."""
        return float(np.interp(way.route_meets_s - self._model.half_length, self._s, self._t))

    def _comes_behind(self, way: ConflictPath, other: ConflictingVehicle, later_s: float = 0.0) -> tuple[bool, bool]:
        """Return whether the other will have passed, or be ahead on the common way, when the ego arrives:
        (surely, likely). `later_s`: the ego arrives so much later (s).
        """
        left = (way.meets_s + 1.0 if way.joins else way.parts_s) - (other.s - other.half_length)
        arrives_s = self._arrives_s(way) + later_s
        return other.speed * _EARLY * arrives_s > left, other.speed * arrives_s > left

    def _leader(self, way: ConflictPath, other: ConflictingVehicle) -> LeadVehicle:
        """Return the other as if it were as far along the route as it is along its way."""
        front = float(self._s[0]) + self._model.half_length
        return LeadVehicle(other.s - other.half_length - way.meets_s - (front - way.route_meets_s), other.speed)

    def _meets(self, way: ConflictPath, other: ConflictingVehicle, margin: Margin) -> bool:
        """True if it would come nearer to the other than the margin while their ways meet."""
        half = self._model.half_length
        t_in = self._arrives_s(way)
        until = way.route_parts_s + half
        when = (self._s > way.route_meets_s - half) & (
            (self._t < t_in + self._joined_s) if way.joins else (self._s < until)
        )
        if not when.any():
            return False
        before = margin.before_m + margin.before_s * other.speed
        behind = margin.behind_m + margin.behind_s * other.speed
        t = self._t[when]
        to_bend_s = max(way.inside_s - other.s, 0.0) / max(other.speed, LEAST_MPS)
        gone = other.speed * np.minimum(t, to_bend_s) + min(other.speed, way.bend_mps) * np.maximum(t - to_bend_s, 0.0)
        s = other.s + (before - behind) / 2.0 + gone
        x, y, yaw = np.interp(s, way.s, way.x), np.interp(s, way.s, way.y), np.interp(s, way.s, way.yaw)
        over = np.maximum(s - way.s[-1], 0.0)
        x, y = x + over * np.cos(yaw), y + over * np.sin(yaw)
        gap = separation(
            (self._x[when], self._y[when], self._yaw[when]),
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
    pull: Callable[[float], float] | None = None,
    horizon_s: float = HORIZON_S,
) -> Array:
    """Return the arc lengths of the ego's center over the horizon if only the line's bounds hold it back (m).

    `pull` gives the highest acceleration of the vehicle at a speed (m/s²), where the profile's is not reached.
    """
    spacing = float(line.s[1]) if len(line.s) > 1 else 1.0
    bounds, last = line.speed, len(line.speed) - 1
    found, lag = [], lag_s if speed < 1.0 else 0.0
    for k in range(round(horizon_s / STEP_S)):
        found.append(s)
        bound = bends * float(bounds[min(int((s + 0.4 * speed) / spacing), last)])
        if k * STEP_S >= lag:
            wanted = toward_speed(speed, min(bound, top_mps), profile)
            speed = max(speed + STEP_S * (wanted if pull is None else min(wanted, pull(speed))), 0.0)
        s += STEP_S * speed
    return np.array(found)
