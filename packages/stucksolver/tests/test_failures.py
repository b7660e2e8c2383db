"""When waiting for a gap is right: everything that speaks against a plan will go on by itself."""

from __future__ import annotations

import pytest

from stucksolver.guard import RejectCode, RejectReason, Verdict
from stucksolver.solver.state_machine.history import passes

C = RejectCode


def refused(*codes):
    return Verdict(rejects=tuple(RejectReason(code=code, detail="why", object_id="car") for code in codes))


@pytest.mark.parametrize(
    ("codes", "moving", "waits"),
    [
        ((C.LANE_ENTRY,), (), True),
        ((C.LANE_ENTRY, C.PATH_NOT_VISIBLE), (), True),
        ((C.PATH_NOT_VISIBLE,), (), False),
        ((C.PATH_NOT_VISIBLE, C.OFF_ROAD), (), False),
        ((C.LANE_ENTRY, C.OFF_ROAD), (), False),
        ((C.GAP,), ("car",), True),
        ((C.GAP, C.PATH_NOT_VISIBLE), ("car",), True),
        ((C.GAP,), (), False),
        ((), (), False),
    ],
)
def test_a_plan_waits_for_traffic_and_for_what_traffic_hides(codes, moving, waits):
    assert passes(refused(*codes), frozenset(moving)) is waits
