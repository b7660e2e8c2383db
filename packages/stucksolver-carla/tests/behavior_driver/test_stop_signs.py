"""A stop sign is obeyed as CARLA's leaderboard judges it: a halt near its box, once."""

from __future__ import annotations

from types import SimpleNamespace

import carla
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver_carla.drivers.behavior.stop_signs import NEAR_M, StopSignWatch, stop_places

DT_S = 0.05
S = np.arange(0.0, 100.0, 0.25)
STRAIGHT = (S, S, np.zeros(len(S)), np.zeros(len(S)))


def sign(x, y, yaw=0.0, z=0.0):
    at = carla.Transform(carla.Location(x, y, z), carla.Rotation(yaw=yaw))
    volume = carla.BoundingBox(carla.Location(0.0, 2.0, 0.0), carla.Vector3D(1.5, 1.5, 1.0))
    return SimpleNamespace(trigger_volume=volume, get_transform=lambda: at)


def halted(watch, front, seconds):
    return [watch.distance_to_stop(front, 0.0, DT_S) for _ in range(round(seconds / DT_S))][-1]


def test_stop_places_need_sign_box_on_line():
    """A sign whose box lies on the line has its place there, and no other sign has."""
    ours, beside, above = sign(40.0, -2.0), sign(40.0, 1.5), sign(40.0, -2.0, z=8.0)
    assert stop_places([beside, ours, above], *STRAIGHT) == pytest.approx([40.0], abs=0.3)


def test_stop_sign_needs_halt_of_1_s():
    """A halt of a second at the sign is enough, and a shorter one is not."""
    watch = StopSignWatch([40.0], 2.4)
    assert watch.distance_to_stop(20.0, 8.0, DT_S) == pytest.approx(20.0)
    assert halted(watch, 39.0, 0.9) == pytest.approx(1.0)
    assert halted(watch, 39.0, 0.2) is None


def test_stop_sign_stop_in_queue_before_it_is_no_halt():
    """A stop in a queue before the sign is not a halt at it."""
    watch = StopSignWatch([40.0], 2.4)
    assert halted(watch, 30.0, 20.0) == pytest.approx(10.0)


def test_stop_signs_are_each_obeyed_and_passed_ones_dropped():
    """Signs on the route are obeyed one by one, and a passed one is dropped."""
    watch = StopSignWatch([40.0, 80.0], 2.4)
    assert halted(watch, 39.2, 1.1) == pytest.approx(40.8)
    assert StopSignWatch([40.0], 2.4).distance_to_stop(41.5, 5.0, DT_S) is None


@given(st.floats(1.0, 6.0), st.floats(0.5, 3.0))
def test_stop_sign_gap_counts_for_any_vehicle_length(half_length, wished):
    """A vehicle of any length halts where the sign counts for it."""
    gap = StopSignWatch([], half_length).gap_m(wished)
    assert gap + half_length < NEAR_M and gap <= wished
    watch = StopSignWatch([40.0], half_length)
    assert halted(watch, 40.0 - gap, 1.1) is None
