"""Models how a vehicle follows a path from its real position and heading: the motion that the guard checks.

The vehicle is a bicycle: the center of its body stays on the path and its rear axle does not slip sideways. The body
lags behind the path's direction by half a wheelbase, so it is not tangent to a bend. A vehicle that begins askew first
drives in its own direction, with a limited turning circle and a limited steering rate. A vehicle off its path is
assumed to keep that offset for the duration of a stop plus a second, because the cause may persist.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from stucksolver.guard.numerics import EPSILON, stopping_distance_m
from stucksolver.guard.policy import TrackingPolicy
from stucksolver.plan.frenet_path import STEP_M, FrenetPath, body_heading
from stucksolver.scene.frenet import Array
from stucksolver.scene.frenet_scene import FrenetScene


def tracked_path(path: FrenetPath, view: FrenetScene, policy: TrackingPolicy, *, reverse: bool = False) -> FrenetPath:
    """Return the path as the ego drives it from its real pose: the same stations, with the body's offsets and headings.

    With `reverse`, `view` and `path` are in the frame of `FrenetScene.backwards`, and the body straightens as it goes.
    That takes steering; `swing_out_motion` is the motion without it.
    """
    target = path.d + _kept_error(path, view, policy)
    if reverse:
        return replace(path, d=target, yaw=view.ego_yaw * np.exp(-(path.s - path.s[0]) / policy.straightens_m))
    lever = view.ego.limits.wheelbase_m / 2
    course = replace(path, d=target).heading()
    if abs(view.ego_yaw - float(course[0])) < policy.askew_rad:
        return replace(path, d=target, yaw=body_heading(course, view.ego_yaw, lever))
    s, d, yaw = _driven_off(path.s, target, course, view, policy)
    count = int(np.searchsorted(path.s, s[-1], side="right"))
    offsets, headings = target.copy(), course.copy()
    offsets[:count], headings[:count] = np.interp(path.s[:count], s, d), np.interp(path.s[:count], s, yaw)
    headings[count - 1 :] = body_heading(course[count - 1 :], float(headings[count - 1]), lever)
    return replace(path, d=offsets, yaw=headings)


def swing_out_motion(path: FrenetPath, view: FrenetScene, policy: TrackingPolicy, lag_s: float) -> FrenetPath | None:
    """Return the motion of an ego that backs up askew with straight wheels, until its tracking error ends the plan.

    `path` and `view` are as for `tracked_path` with `reverse`. None if the body is aligned with the path.
    """
    askew = view.ego_yaw - float(path.heading()[0])
    if abs(askew) < policy.askew_rad:
        return None
    way_m = stopping_distance_m(float(path.speed.max()), view.ego.limits.comfort_braking_mps2, lag_s)
    ends_m = policy.error_m + math.sin(abs(askew)) * way_m
    offset = view.ego_d - path.d[0] + math.tan(askew) * (path.s - path.s[0])
    return replace(path, d=path.d + np.clip(offset, -ends_m, ends_m), yaw=np.full(len(path.s), view.ego_yaw))


def _kept_error(path: FrenetPath, view: FrenetScene, policy: TrackingPolicy) -> Array:
    """(stations,): lateral offset of the body's center from the path (m, left positive)."""
    error = view.ego_d - float(path.d[0])
    if abs(error) < policy.beside_m:
        return np.zeros(len(path.s))
    speed = abs(view.ego.speed_mps)
    kept_m = stopping_distance_m(speed, view.ego.limits.comfort_braking_mps2, policy.kept_s)
    beyond = np.clip((path.s - path.s[0] - kept_m) / policy.worked_off_m, 0.0, 1.0)
    result: Array = error * (1 + np.cos(np.pi * beyond)) / 2
    return result


def _driven_off(
    stations: Array, target: Array, course: Array, view: FrenetScene, policy: TrackingPolicy
) -> tuple[list[float], list[float], list[float]]:
    """Return the center's arc lengths and offsets (m) and the body's headings (rad) while an askew ego joins its path.

    `stations`, `target` and `course`, each (stations,): arc lengths (m), offsets (m) and directions (rad) of the path.
    """
    lever_m = view.ego.limits.wheelbase_m / 2
    lock = 1.0 / view.ego.limits.min_turn_radius_m
    first, offsets, tangents = float(stations[0]), target.tolist(), course.tolist()
    s, d, yaw, bend = first, float(target[0]), view.ego_yaw, 0.0
    rear_s, rear_d = s - lever_m * math.cos(yaw), d - lever_m * math.sin(yaw)
    columns: tuple[list[float], list[float], list[float]] = ([s], [d], [yaw])
    for _ in range(int(policy.settles_m / STEP_M)):
        k = min(int((s - first) / STEP_M), len(offsets) - 2)
        part = min(max((s - first) / STEP_M - k, 0.0), 1.0)
        tangent = tangents[k] + part * (tangents[k + 1] - tangents[k])
        offset = d - offsets[k] - part * (offsets[k + 1] - offsets[k])
        approach = min(max(-offset / (2 * policy.reach_m), -policy.approach_rad), policy.approach_rad)
        moves = yaw + math.atan(lever_m * bend)
        wanted = (tangents[k + 1] - tangents[k]) / STEP_M + 2.0 / policy.reach_m * (approach + tangent - moves)
        most = lock / policy.lock_m * STEP_M
        bend = min(max(min(max(wanted, bend - most), bend + most), -lock), lock)
        rear_s += STEP_M * math.cos(yaw + bend * STEP_M / 2)
        rear_d += STEP_M * math.sin(yaw + bend * STEP_M / 2)
        yaw += bend * STEP_M
        s, d = max(rear_s + lever_m * math.cos(yaw), s + EPSILON), rear_d + lever_m * math.sin(yaw)
        for column, value in zip(columns, (s, d, yaw), strict=True):
            column.append(value)
        if abs(offset) < policy.beside_m and abs(tangent - yaw) < policy.askew_rad:
            break
    return columns
