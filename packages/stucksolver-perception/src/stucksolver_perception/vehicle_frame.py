"""Converts from the local frame to the vehicle frame at a pose. Heights are relative to the ground at the pose."""

from __future__ import annotations

import math

import numpy as np

from stucksolver_perception.measurements import Floats, PoseEstimate
from stucksolver_perception.rig import SensorMount


def into_vehicle(boxes: Floats, pose: PoseEstimate) -> Floats:
    """Return boxes (n, k) of the local frame, with x, y, z first and the yaw last, in the vehicle frame."""
    moved: Floats = boxes.copy()
    c, n = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    dx, dy = boxes[:, 0] - pose.x_m, boxes[:, 1] - pose.y_m
    moved[:, 0], moved[:, 1] = dx * c + dy * n, dy * c - dx * n
    moved[:, 2] = boxes[:, 2] - pose.z_m
    moved[:, -1] = np.remainder(boxes[:, -1] - pose.yaw_rad + math.pi, math.tau) - math.pi
    return moved


def boxes_in_body(pose: Floats, boxes: Floats) -> Floats:
    """Return boxes (n, k) of the local frame, with x, y, z first and the yaw last, in the frame of the ego's body.

    The body pitches and rolls with its sensors. `pose` starts with x, y, z (m), yaw, pitch and roll (rad), as in
    recordings.
    """
    x, y, z, yaw, pitch, roll = pose[:6].tolist()
    angles = {"yaw_deg": math.degrees(yaw), "pitch_deg": math.degrees(pitch), "roll_deg": math.degrees(roll)}
    turn = SensorMount(x_m=0.0, y_m=0.0, z_m=0.0, **angles).to_vehicle()[:3, :3]
    moved: Floats = boxes.copy()
    moved[:, :3] = (boxes[:, :3] - (x, y, z)) @ turn
    moved[:, -1] = boxes[:, -1] - yaw
    return moved


def points_into_vehicle(points: Floats, pose: PoseEstimate) -> Floats:
    """Return points (n, 2) of the local frame in the vehicle frame."""
    c, n = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    dx, dy = points[:, 0] - pose.x_m, points[:, 1] - pose.y_m
    return np.stack([dx * c + dy * n, dy * c - dx * n], axis=1)
