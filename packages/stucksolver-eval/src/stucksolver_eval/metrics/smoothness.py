"""Bench2Drive's driving smoothness (comfort): the share of one-second blocks within nuPlan's bounds of comfort.

The rule has known errors: samples come at 20 Hz but are taken as 10 Hz, which halves jerks; the yaw rate is in degrees
per second but compared with bounds in radians; the yaw acceleration is the yaw rate again. `AS_RATED` has these errors,
`CORRECTED` does not. Bounds: Karnchanachari et al., "Toward learning-based planning: the nuPlan benchmark for
real-world autonomous driving" (2024).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

BLOCK = 20
"""Number of samples in a block: one second at 20 Hz."""
WINDOW, ORDER = 7, 2
"""Window and order of the Savitzky-Golay filter. As in Bench2Drive's tool."""
LON_MPS2 = (-4.05, 2.40)
"""Bounds of the longitudinal acceleration (m/s²), from nuPlan."""
LAT_MPS2 = 4.89
"""Bound of the lateral acceleration (m/s²), from nuPlan."""
JERK_MPS3 = 8.37
"""Bound of the jerk (m/s³), from nuPlan."""
LON_JERK_MPS3 = 4.13
"""Bound of the longitudinal jerk (m/s³), from nuPlan."""
YAW_ACCELERATION, YAW_RATE = 1.93, 0.95
"""Bounds of the yaw acceleration (rad/s²) and of the yaw rate (rad/s), from nuPlan."""
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rule:
    """`step_s` is the assumed time between samples (s); `yaw_unit` is the factor on degrees per second."""

    step_s: float
    yaw_unit: float
    derives_yaw: bool


AS_RATED = Rule(step_s=0.1, yaw_unit=1.0, derives_yaw=False)
CORRECTED = Rule(step_s=0.05, yaw_unit=math.pi / 180.0, derives_yaw=True)


def smoothness(info: Mapping[str, Array], rule: Rule = AS_RATED) -> float:
    """Return the share of good blocks of one route; 1 or 0 for one of 20 samples or fewer.

    Args:
        info: `acceleration`, `angular_velocity` (deg/s), `forward_vector` and `right_vector`, each (ticks, 3).
        rule: With or without the benchmark's errors.

    Raises:
        ValueError: There are fewer than 3 samples.
    """
    count = len(info["acceleration"])
    if count < ORDER + 1:
        raise ValueError(f"smoothness needs at least {ORDER + 1} samples, got {count}")
    size = min(count, BLOCK)
    blocks = count // size
    good = _good({name: values[: blocks * size].reshape(blocks, size, 3) for name, values in info.items()}, rule)
    return float(good.mean())


def _good(info: Mapping[str, Array], rule: Rule) -> NDArray[np.bool_]:
    """True for each block, of shape (blocks, samples, 3), within all bounds."""
    smooth, slope = filters(info["acceleration"].shape[1])
    accelerations = info["acceleration"][..., :2]
    lon = (accelerations * info["forward_vector"][..., :2]).sum(axis=-1) @ smooth.T
    lat = (accelerations * info["right_vector"][..., :2]).sum(axis=-1) @ smooth.T
    size = np.hypot(accelerations[..., 0], accelerations[..., 1]) @ smooth.T
    jerk, lon_jerk = size @ slope.T / rule.step_s, lon @ slope.T / rule.step_s
    rate = _unwrapped(info["angular_velocity"][..., 2] * rule.yaw_unit) @ smooth.T
    yaw_acceleration = rate @ slope.T / rule.step_s if rule.derives_yaw else rate
    return np.asarray(
        _within(lon, *LON_MPS2)
        & _within(lat, -LAT_MPS2, LAT_MPS2)
        & _within(jerk, -JERK_MPS3, JERK_MPS3)
        & _within(lon_jerk, -LON_JERK_MPS3, LON_JERK_MPS3)
        & _within(yaw_acceleration, -YAW_ACCELERATION, YAW_ACCELERATION)
        & _within(rate, -YAW_RATE, YAW_RATE)
    )


def _within(values: Array, low: float, high: float) -> NDArray[np.bool_]:
    return np.asarray(((values > low) & (values < high)).all(axis=-1))


def _unwrapped(rates: Array) -> Array:
    """Return unwrapped rates, because the benchmark treats them like angles: jumps beyond pi lose multiples of 2 pi."""
    turns = np.zeros_like(rates)
    turns[..., 1:] = np.cumsum(np.round(np.diff(rates, axis=-1) / math.tau), axis=-1)
    return np.asarray(rates - math.tau * turns)


@lru_cache(maxsize=32)
def filters(count: int) -> tuple[Array, Array]:
    """Return Savitzky and Golay's filters (1964) as matrices on `count` samples: smoothing, and the slope per sample.

    Parabolas are fitted to windows of 7 samples (all, if there are fewer); the ends use the parabolas of the first and
    the last window.
    """
    window = min(WINDOW, count)
    smooth, slope = np.zeros((count, count)), np.zeros((count, count))
    for k in range(count):
        first = min(max(k - window // 2, 0), count - window)
        places = np.arange(window) + first - k
        fit = np.linalg.pinv(np.vander(places, ORDER + 1, increasing=True).astype(np.float64))
        smooth[k, first : first + window] = fit[0]
        slope[k, first : first + window] = fit[1]
    return smooth, slope
