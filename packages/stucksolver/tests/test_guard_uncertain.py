"""What perception is not sure of makes others larger, and the ego too against the borders of its lane."""

from __future__ import annotations

import pytest

from stucksolver.guard import Guard, RejectCode
from stucksolver.plan.behaviors import KeepLane
from stucksolver.scene import ObjectKind
from stucksolver.scene.frenet_scene import SURE_SDS, FrenetScene
from worlds import World, straight_road, thing

ROAD = straight_road()
GUARD = Guard()
SLOW = KeepLane(distance_m=40.0, speed_mps=2.0)
HALF_WIDTH_M = 1.85 / 2
BARRIER_HALF_M = 0.95
LEAST_GAP_M = 0.3
"""To what stands, at walking pace: `ClearancePolicy.standing_gap_m`."""


def codes(gap_m: float, sd_m: float | None) -> set[RejectCode]:
    barrier = thing("it", 75.0, HALF_WIDTH_M + BARRIER_HALF_M + gap_m, kind=ObjectKind.BARRIER)
    view = World(ROAD, [barrier.model_copy(update={"position_sd_m": sd_m})]).view()
    return {reject.code for reject in GUARD.accept([SLOW], view, False)[0].rejects}


@pytest.mark.parametrize("sd_m", [0.05, 0.1, 0.3])
def test_a_gap_counts_from_two_standard_deviations_nearer(sd_m: float) -> None:
    needed_m = LEAST_GAP_M + SURE_SDS * sd_m
    assert RejectCode.GAP not in codes(needed_m + 0.02, sd_m)
    assert RejectCode.GAP in codes(needed_m - 0.02, sd_m)


@pytest.mark.parametrize("sd_m", [None, 0.0])
def test_who_is_exact_is_as_large_as_it_is(sd_m: float | None) -> None:
    assert RejectCode.GAP not in codes(LEAST_GAP_M + 0.02, sd_m)
    assert RejectCode.GAP in codes(LEAST_GAP_M - 0.02, sd_m)


def test_proposals_see_the_same_size_as_the_guard() -> None:
    car = thing("it", 75.0, 0.0, kind=ObjectKind.CAR).model_copy(update={"position_sd_m": 0.2})
    view = World(ROAD, [car]).view()
    assert isinstance(view, FrenetScene)
    assert view.half_width[0] == pytest.approx(car.width_m / 2 + SURE_SDS * 0.2)
    assert view.half_length[0] == pytest.approx(car.length_m / 2 + SURE_SDS * 0.2)
