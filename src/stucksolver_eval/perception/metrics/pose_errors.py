"""How far estimated poses are off the true ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stucksolver.perception.measurements import Floats

NINES = 95
CHI_SQUARE_95 = 5.991
"""Of two degrees of freedom: so large an error, in standard deviations squared, is exceeded once in twenty times."""


@dataclass(frozen=True)
class PoseErrors:
    """Over all moments; lateral: across the true heading."""

    moments: int
    position_rms_m: float
    position_p95_m: float
    position_worst_m: float
    lateral_rms_m: float
    yaw_rms_rad: float
    speed_rms_mps: float
    within_95: float
    """Share of the positions within the 95 % ellipse that the estimate claims: below 0.95 it is too sure."""


def pose_errors(estimated: Floats, true: Floats, covariance: Floats) -> PoseErrors | None:
    """Of poses at the same moments.

    Args:
        estimated: (n, 4) x, y (m), yaw (rad), speed (m/s).
        true: (n, 4), the same.
        covariance: (n, 2, 2) of x and y (m²), as estimated.

    Returns:
        The errors; None where there are no moments.
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
    """The root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
