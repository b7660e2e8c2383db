"""How a vehicle drives a path from where it is and as it points: the motion that the guard examines.

The vehicle is a bicycle whose body's centre is kept on the path and whose rear axle does not slip aside. Its body lags
behind the path's direction by half a wheelbase, so that it is not tangent where the path bends. One that begins askew
first drives off as it points, with a limited turning circle and a steering wheel that takes its time. One that is
beside its path is taken to stay so far beside it as a stop takes, and a second more: whatever keeps it there may last.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from stucksolver.decision.manoeuvre import STEP_M, Manoeuvre, body_heading
from stucksolver.scene.frenet import Array
from stucksolver.scene.view import View

ASKEW_RAD = 0.1
"""Turned by less from where the body should point, it is on its way without driving off first."""
BESIDE_M = 0.05
KEPT_S, WORKED_OFF_M = 1.0, 6.0
"""A tracking error is kept for so long beyond a stop, and then worked off within so many metres."""
SETTLES_M, LOCK_M = 20.0, 1.5
"""An askew start is followed up for so long; the wheels are turned from straight to their lock within 1.5 m."""
STRAIGHTENS_M = 3.0
"""Backing up, what a body is askew fades over so much way."""
REACH_M, APPROACH_RAD = 2.0, 0.45
"""The centre comes back to the path over about so much travel, and towards it at no steeper angle."""


def tracked(path: Manoeuvre, view: View, *, reverse: bool = False) -> Manoeuvre:
    """The path as the ego drives it from its real pose: the same stations with offsets and headings of the body.

    `view` and `path` are those of `View.backwards` with `reverse`; backing up, the body is straightened on the way.
    """
    target = path.d + _kept_error(path, view)
    if reverse:
        return replace(path, d=target, yaw=view.ego_yaw * np.exp(-(path.s - path.s[0]) / STRAIGHTENS_M))
    lever = view.ego.limits.wheelbase_m / 2
    course = replace(path, d=target).heading()
    if abs(view.ego_yaw - float(course[0])) < ASKEW_RAD:
        return replace(path, d=target, yaw=body_heading(course, view.ego_yaw, lever))
    s, d, yaw = _driven_off(path.s, target, course, view, lever)
    count = int(np.searchsorted(path.s, s[-1], side="right"))
    offsets, headings = target.copy(), course.copy()
    offsets[:count], headings[:count] = np.interp(path.s[:count], s, d), np.interp(path.s[:count], s, yaw)
    headings[count - 1 :] = body_heading(course[count - 1 :], float(headings[count - 1]), lever)
    return replace(path, d=offsets, yaw=headings)


def _kept_error(path: Manoeuvre, view: View) -> Array:
    """By how much the centre stays beside the path at each station."""
    error = view.ego_d - float(path.d[0])
    if abs(error) < BESIDE_M:
        return np.zeros(len(path.s))
    speed = abs(view.ego.speed_mps)
    kept = speed**2 / (2 * view.ego.limits.comfort_braking_mps2) + KEPT_S * speed
    beyond = np.clip((path.s - path.s[0] - kept) / WORKED_OFF_M, 0.0, 1.0)
    result: Array = error * (1 + np.cos(np.pi * beyond)) / 2
    return result


def _driven_off(
    stations: Array, target: Array, course: Array, view: View, lever_m: float
) -> tuple[list[float], list[float], list[float]]:
    """The centre's places and the body's headings while a start askew is steered onto a path."""
    lock = 1.0 / view.ego.limits.min_turn_radius_m
    first, offsets, tangents = float(stations[0]), target.tolist(), course.tolist()
    s, d, yaw, bend = first, float(target[0]), view.ego_yaw, 0.0
    rear_s, rear_d = s - lever_m * math.cos(yaw), d - lever_m * math.sin(yaw)
    found: tuple[list[float], list[float], list[float]] = ([s], [d], [yaw])
    for _ in range(int(SETTLES_M / STEP_M)):
        k = min(int((s - first) / STEP_M), len(offsets) - 2)
        part = min(max((s - first) / STEP_M - k, 0.0), 1.0)
        tangent = tangents[k] + part * (tangents[k + 1] - tangents[k])
        beside = d - offsets[k] - part * (offsets[k + 1] - offsets[k])
        approach = min(max(-beside / (2 * REACH_M), -APPROACH_RAD), APPROACH_RAD)
        moves = yaw + math.atan(lever_m * bend)
        wanted = (tangents[k + 1] - tangents[k]) / STEP_M + 2.0 / REACH_M * (approach + tangent - moves)
        most = lock / LOCK_M * STEP_M
        bend = min(max(min(max(wanted, bend - most), bend + most), -lock), lock)
        rear_s += STEP_M * math.cos(yaw + bend * STEP_M / 2)
        rear_d += STEP_M * math.sin(yaw + bend * STEP_M / 2)
        yaw += bend * STEP_M
        s, d = max(rear_s + lever_m * math.cos(yaw), s + 1e-6), rear_d + lever_m * math.sin(yaw)
        for column, value in zip(found, (s, d, yaw), strict=True):
            column.append(value)
        if abs(beside) < BESIDE_M and abs(tangent - yaw) < ASKEW_RAD:
            break
    return found
