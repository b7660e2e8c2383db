"""Errors of estimated poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stucksolver_perception.measurements import Floats

NINES = 95
"""Percentile of the reported errors."""
CHI_SQUARE_95 = 5.991
"""95 % quantile of the chi-squared distribution with two degrees of freedom."""


@dataclass(frozen=True)
class PoseErrors:
    """Errors over all poses. Lateral errors are perpendicular to the true heading."""

    moments: int
    position_rms_m: float
    position_p95_m: float
    position_worst_m: float
    lateral_rms_m: float
    yaw_rms_rad: float
    speed_rms_mps: float
    within_95: float
    """Share of positions within the estimate's own 95 % ellipse; below 0.95 the estimate is overconfident."""


def pose_errors(estimated: Floats, true: Floats, covariance: Floats) -> PoseErrors | None:
    """Return the errors of poses at the same times.

    Args:
        estimated: Shape (n, 4): x, y (m), yaw (rad), speed (m/s).
        true: Shape (n, 4): the same.
        covariance: Shape (n, 2, 2): estimated covariance of x and y (m²).

    Returns:
        The errors; None without poses.
    """
    if not len(estimated):
        return None
    off = estimated - true
    yaw = (off[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    away = np.hypot(off[:, 0], off[:, 1])
    lateral = -off[:, 0] * np.sin(true[:, 2]) + off[:, 1] * np.cos(true[:, 2])
    sigmas = np.einsum("ni,ni->n", off[:, :2], np.linalg.solve(covariance, off[:, :2, None])[:, :, 0])
    return PoseErrors(
        moments=len(off),
        position_rms_m=rms(away),
        position_p95_m=float(np.percentile(away, NINES)),
        position_worst_m=float(away.max()),
        lateral_rms_m=rms(lateral),
        yaw_rms_rad=rms(yaw),
        speed_rms_mps=rms(off[:, 3]),
        within_95=float((sigmas < CHI_SQUARE_95).mean()),
    )


def rms(values: Floats) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
