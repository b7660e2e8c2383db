"""Who pulls out into the ego's way, and who only seems to."""

from __future__ import annotations

import numpy as np
import pytest

from stucksolver_carla.drivers.behavior.path import Projection
from stucksolver_carla.drivers.behavior.predictive_braking import ACROSS_NOISE_MPS, vehicles_pulling_out
from stucksolver_carla.drivers.behavior.route_bodies import RouteObjects
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel

CAR = VehicleModel(half_length=2.45, half_width=0.95, wheelbase=2.9, wheel_lock=1.2)
HERE = Projection(100.0, 0.0, 0.0)


def found(gap_m, nears_mps, speed_mps, passing_mps=0.0):
    """One in the lane beside, on the left, so far ahead."""
    ones = np.ones(1)
    s = HERE.s + CAR.half_length + gap_m + 2.4
    body = RouteObjects(
        actor_id=np.array([1]),
        is_walker=np.zeros(1, dtype=bool),
        s=s * ones,
        d=-3.5 * ones,
        along=2.4 * ones,
        aside=0.9 * ones,
        vs=speed_mps * ones,
        vd=nears_mps * ones,
    )
    return bool(vehicles_pulling_out(body, HERE, CAR, passing_mps))


@pytest.mark.parametrize(("gap_m", "nears_mps"), [(1.0, 0.6), (1.0, 0.4), (8.0, 0.4)])
def test_pull_out_passed_vehicle_drifting_is_ignored(gap_m, nears_mps):
    """A vehicle that is being passed and seems to drift does not pull out."""
    assert found(gap_m, nears_mps, 8.0)
    assert not found(gap_m, nears_mps, 8.0, passing_mps=12.5)


@pytest.mark.parametrize(("gap_m", "nears_mps", "passing_mps"), [(3.0, 1.2, 12.0), (20.0, 0.8, 12.0), (3.0, 0.4, 7.0)])
def test_pull_out_vehicle_in_path_before_pass_is_found(gap_m, nears_mps, passing_mps):
    """A vehicle that would be in the path before it is passed pulls out.

    A vehicle as fast as the ego is never passed.
    """
    assert found(gap_m, nears_mps, 8.0, passing_mps)


def test_pull_out_drift_within_noise_counts_only_without_pass():
    """A drift within the noise counts only for a vehicle that the ego does not pass."""
    assert not found(30.0, ACROSS_NOISE_MPS, 5.0, passing_mps=5.5)
    assert found(30.0, ACROSS_NOISE_MPS, 5.0, passing_mps=4.5)
