"""One definition of a near miss: TTC below 1 s, or a gap below 0.3 m, to an actor that moves."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("carla")

import stucksolver_eval
from stucksolver.scene.boxes import separation, time_to_contact
from stucksolver_eval.near_miss import is_near

EGO_HALF, CAR_HALF = (2.4, 1.0), (2.0, 1.0)


def near(x, y, mps=(3.0, 0.0), yaw=0.0, ego_mps=(5.0, 0.0)):
    """Is a car at (x, y) near an ego at the origin that heads along x?"""
    found = is_near((0.0, 0.0, 0.0), ego_mps, EGO_HALF, (x, y, yaw), mps, CAR_HALF)
    return bool(found)


@pytest.mark.parametrize(("gap", "is_one"), [(0.31, False), (0.29, True), (0.0, True)])
def test_a_gap_below_0_3_m_beside_us_is_one(gap, is_one):
    assert near(0.0, 2.0 + gap, mps=(5.0, 0.0)) is is_one


@pytest.mark.parametrize(("ttc_s", "is_one"), [(1.05, False), (0.95, True), (0.5, True)])
@pytest.mark.parametrize("closing_mps", [2.0, 8.0, 30.0])
def test_near_miss_ttc_below_1_s_counts_at_any_speed(ttc_s, closing_mps, is_one):
    """A predicted contact in less than 1 s is a near miss at any speed."""
    assert near(4.4 + closing_mps * ttc_s, 0.0, mps=(5.0 - closing_mps, 0.0001 + 0.2)) is is_one


def test_who_stands_is_none_however_near():
    assert not near(0.0, 2.1, mps=(0.05, 0.0))
    assert near(0.0, 2.1, mps=(0.11, 0.0), ego_mps=(0.0, 0.0))


def test_who_opens_the_gap_is_none():
    assert not near(4.4 + 0.5, 0.0, mps=(9.0, 0.0))


def test_near_miss_crossing_behind_counts_only_before_ego_leaves():
    """A vehicle that crosses behind the ego is a near miss only if the ego does not leave in time."""
    assert near(0.0, -8.0, mps=(0.0, 9.0), yaw=math.pi / 2, ego_mps=(0.0, 0.0))
    assert not near(0.0, -8.0, mps=(0.0, 9.0), yaw=math.pi / 2, ego_mps=(12.0, 0.0))


def test_the_boxes_are_turned():
    assert not near(0.0, 2.5, mps=(5.0, 0.0))
    assert near(0.0, 2.5, mps=(5.0, 0.0), yaw=math.pi / 2)


PLACE, YAW, SPEED = st.floats(-30, 30), st.floats(-4, 4), st.floats(-20, 20)


@given(PLACE, PLACE, YAW, YAW, SPEED, SPEED)
def test_time_to_contact_is_first_touch_of_boxes(x, y, yaw, ego_yaw, vx, vy):
    """The time to contact is the time at which the boxes first touch."""
    found = float(time_to_contact((0, 0, ego_yaw), EGO_HALF, (x, y, yaw), CAR_HALF, (vx, vy)))
    times = np.arange(0.0, 3.0, 0.004)
    gaps = separation((0, 0, ego_yaw), EGO_HALF, (x + vx * times, y + vy * times, yaw), CAR_HALF)
    touching = times[gaps < -0.001]
    clear_until = times[-1] if found == math.inf else min(found - 1e-6, times[-1])
    assert not (gaps[times < clear_until] < -1e-6).any()
    if len(touching):
        assert found <= touching[0]


def test_many_at_once_are_each_as_alone():
    rng = np.random.default_rng(1)
    x, y, yaw, vx, vy = (rng.uniform(-10, 10, 50) for _ in range(5))
    together = is_near((0.0, 0.0, 0.0), (5.0, 0.0), EGO_HALF, (x, y, yaw), (vx, vy), CAR_HALF)
    alone = [near(x[k], y[k], mps=(vx[k], vy[k]), yaw=yaw[k]) for k in range(50)]
    assert together.tolist() == alone
    assert 5 < sum(alone) < 45


def test_nobody_else_defines_one():
    """Whoever speaks of near misses takes them from the one place."""
    sources = {path: path.read_text(encoding="utf-8") for path in Path(stucksolver_eval.__path__[0]).rglob("*.py")}
    makers = [path.name for path, text in sources.items() if 'kind="near_miss"' in text]
    assert makers == ["near_miss.py"]
