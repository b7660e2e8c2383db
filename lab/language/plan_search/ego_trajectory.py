"""Trajectory of the ego under a plan: poses over time, joined from one behavior to the next."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stucksolver.guard import ProvenPlan
from stucksolver.plan.speed_profile import rollout
from stucksolver.scene import Surroundings
from stucksolver.scene.frenet import Array
from stucksolver.scene.frenet_scene import FrenetScene


@dataclass(frozen=True)
class EgoTrajectory:
    """Poses of the ego in the local frame of its surroundings.

    Attributes:
        t: Times from the standstill on, ascending (n,) (s).
        pose: x, y and heading (n, 3) (m, m, rad counter-clockwise).
        speed_mps: Speed at its end, negative in reverse.
    """

    t: Array
    pose: Array
    speed_mps: float

    @property
    def end_s(self) -> float:
        """Time of its end (s)."""
        return float(self.t[-1])

    def pose_at(self, t_s: float) -> tuple[float, float, float]:
        """Return x, y (m) and heading (rad) at a time; the last pose after its end."""
        x, y, yaw = (float(np.interp(t_s, self.t, self.pose[:, k])) for k in range(3))
        return x, y, yaw

    def extended(self, t: Array, pose: Array, speed_mps: float) -> EgoTrajectory:
        """Append poses whose times (s) count from the end of this one."""
        return EgoTrajectory(np.concatenate([self.t, self.end_s + t]), np.concatenate([self.pose, pose]), speed_mps)


def begin(surroundings: Surroundings) -> EgoTrajectory:
    """Return a trajectory of only the ego's present pose."""
    ego = surroundings.ego
    return EgoTrajectory(np.zeros(1), np.array([[ego.x_m, ego.y_m, ego.yaw_rad]]), ego.speed_mps)


def stand(trail: EgoTrajectory, duration_s: float) -> EgoTrajectory:
    """Append a stop of this duration (s)."""
    return trail.extended(np.array([duration_s]), trail.pose[-1:], 0.0)


def drive(trail: EgoTrajectory, proven: ProvenPlan, view: FrenetScene) -> EgoTrajectory:
    """Append a path proven by the guard, driven as fast as its bounds and the vehicle's comfort limits allow."""
    view = view.backwards if proven.reverse else view
    path, limits = proven.path, view.ego.limits
    profile = rollout(path, abs(trail.speed_mps), limits.comfort_acceleration_mps2, limits.comfort_braking_mps2)
    x, y, road_yaw = view.frame.to_local(path.s, path.d)
    yaw = np.unwrap(road_yaw + path.heading() + (math.pi if proven.reverse else 0.0))
    yaw += 2.0 * math.pi * round((float(trail.pose[-1, 2]) - float(yaw[0])) / (2.0 * math.pi))
    speed = 0.0 if path.stops else float(profile.v[-1])
    return trail.extended(profile.t, np.column_stack([x, y, yaw]), -speed if proven.reverse else speed)


def moved(surroundings: Surroundings, trail: EgoTrajectory) -> Surroundings:
    """Return the surroundings with the ego at the end of a trajectory and all others at their positions."""
    x, y, yaw = trail.pose_at(trail.end_s)
    ego = surroundings.ego.model_copy(update={"x_m": x, "y_m": y, "yaw_rad": yaw, "speed_mps": trail.speed_mps})
    return surroundings.model_copy(update={"ego": ego})
