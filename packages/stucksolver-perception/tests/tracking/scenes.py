"""Detections of simulated objects, with the noise from look to look that the shipped detector has near by."""

from __future__ import annotations

import numpy as np

from stucksolver_perception.measurements import Detections, PoseEstimate

CAR = (4.5, 1.9, 1.5)
STEP_S = 0.1


def pose(time_s, x=0.0, y=0.0, yaw=0.0, speed=0.0):
    return PoseEstimate(time_s, x, y, 0.0, yaw, speed, 0.0, np.diag([0.04, 0.04, 1e-4, 0.0025]))


def detections(time_s, xy, rng, velocity=(0.0, 0.0), yaw=0.0, label=0, size=CAR, score=0.8, noise=1.0):
    """Boxes of one label at `xy` (n, 2) in the vehicle frame; `noise` scales what is added."""
    xy = np.atleast_2d(np.asarray(xy, float)) if len(xy) else np.zeros((0, 2))
    n = len(xy)
    center = np.column_stack([xy + rng.normal(0, 0.1 * noise, (n, 2)), np.full(n, size[2] / 2)])
    return Detections(
        time_s,
        np.full(n, label),
        np.full(n, score),
        center,
        np.tile(np.asarray(size, float), (n, 1)),
        np.broadcast_to(yaw, n) + rng.normal(0, 0.1 * noise, n),
        np.broadcast_to(velocity, (n, 2)) + rng.normal(0, 0.5 * noise, (n, 2)),
    )


def nothing(time_s):
    return detections(time_s, [], np.random.default_rng(0))


def follow(tracker, path, seconds, rng, start_s=0.0, **more):
    """Update with one object whose place and velocity `path(t)` gives; the last answer."""
    told = ()
    for k in range(round(seconds / STEP_S)):
        t = start_s + k * STEP_S
        place, velocity = path(t)
        told = tracker.update(detections(t, [place], rng, velocity, **more), pose(t))
    return told
