"""Converts between the local frame and the vehicle frame at a pose; heights stay relative to the ground at the pose."""

from __future__ import annotations

import math

import numpy as np

from stucksolver.perception.measurements import Floats, PoseEstimate


def into_vehicle(boxes: Floats, pose: PoseEstimate) -> Floats:
    """Convert boxes (n, k) of the local frame, x, y, z first and the yaw last, to the vehicle frame; the rest is
    kept.
    """
    moved: Floats = boxes.copy()
    c, n = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    dx, dy = boxes[:, 0] - pose.x_m, boxes[:, 1] - pose.y_m
    moved[:, 0], moved[:, 1] = dx * c + dy * n, dy * c - dx * n
    moved[:, 2] = boxes[:, 2] - pose.z_m
    moved[:, -1] = np.remainder(boxes[:, -1] - pose.yaw_rad + math.pi, math.tau) - math.pi
    return moved


def points_into_vehicle(points: Floats, pose: PoseEstimate) -> Floats:
    """Convert points (n, 2) of the local frame to the vehicle frame."""
    c, n = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    dx, dy = points[:, 0] - pose.x_m, points[:, 1] - pose.y_m
    return np.stack([dx * c + dy * n, dy * c - dx * n], axis=1)
