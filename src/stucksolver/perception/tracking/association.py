"""Which detection belongs to which track."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stucksolver.perception.measurements import Floats
from stucksolver.perception.tracking.body import Body
from stucksolver.perception.tracking.groups import GROUP_OF_LABEL
from stucksolver.perception.tracking.noise import Measured

GATE = 49.0
"""Squared Mahalanobis distance in x, y. Wide (7 standard deviations), for detectors are at times twice as wrong as
assumed; what keeps two bodies apart is the whole assignment, and that bodies cannot overlap: `reach_m`."""
OTHER_GROUP = 36.0
"""What it costs to take a detection of another group: a cyclist called a car for one look stays one object."""
NEVER = 1e6


def assign(bodies: list[Body], seen: Measured) -> list[tuple[int, int]]:
    """Pairs (body, detection) of least total distance, each used once.

    Centres are compared after the tracks were brought forward with their velocity (Yin, Zhou, Krähenbühl,
    "Center-based 3D Object Detection and Tracking", 2021), by Mahalanobis distance (Chiu et al., "Probabilistic 3D
    Multi-Object Tracking", 2020), and the whole assignment is solved at once (Weng et al., "AB3DMOT", 2020). The cost
    is the negative log-likelihood: without the determinant, a hidden track that may be anywhere would take what
    belongs to others.
    """
    from scipy.optimize import linear_sum_assignment  # type: ignore[import-untyped]

    if not bodies or not len(seen):
        return []
    squared, spread = _distances(bodies, seen)
    allowed = squared <= GATE
    rows, columns = linear_sum_assignment(np.where(allowed, squared + spread, NEVER))
    return [(int(i), int(j)) for i, j in zip(rows, columns, strict=True) if allowed[i, j]]


def part_of_another(bodies: list[Body], seen: Measured, j: int) -> bool:
    """Does the middle of a detection lie in the box of one of these bodies? Then it is no second object."""
    x, y = seen.z[j, :2]
    for body in bodies:
        cos, sin = np.cos(body.x[3]), np.sin(body.x[3])
        dx, dy = x - body.x[0], y - body.x[1]
        inside = abs(dx * cos + dy * sin) < body.size[0] / 2 and abs(dy * cos - dx * sin) < body.size[1] / 2
        if inside and GROUP_OF_LABEL[body.label] == GROUP_OF_LABEL[seen.label[j]]:
            return True
    return False


def _distances(bodies: list[Body], seen: Measured) -> tuple[Floats, Floats]:
    """(bodies, detections) each: squared Mahalanobis distances, with what another group costs, NEVER beyond reach; and
    the logarithm of the determinant of their covariance."""
    at = np.array([body.x[:2] for body in bodies])
    covariance = np.array([body.p[:2, :2] for body in bodies])
    groups = np.array([GROUP_OF_LABEL[body.label] for body in bodies])
    reach = np.array([body.group.reach_m for body in bodies])
    reach = reach + np.minimum(reach, 2.0 * np.sqrt(covariance.trace(axis1=1, axis2=2) / 2.0))
    off = seen.z[None, :, :2] - at[:, None]
    whole = covariance[:, None] + seen.noise[None, :, :2, :2]
    squared: Floats = np.einsum("ijk,ijkl,ijl->ij", off, np.linalg.inv(whole), off)
    squared = squared + OTHER_GROUP * (groups[:, None] != GROUP_OF_LABEL[seen.label][None])
    beyond: NDArray[np.bool_] = np.hypot(off[..., 0], off[..., 1]) > reach[:, None]
    return np.where(beyond, NEVER, squared), np.log(np.linalg.det(whole))
