"""Drives of the oracle that once ended in a contact: one for each kind of fault that was mended."""

from __future__ import annotations

import pytest

from lab.benchmarks.guard_oracle.campaign import one

FOUND = {
    "only a gentle stop was tried": (60, 1000009, 1),
    "waited in the nearest lane of a junction, not before it": (60, 1000064, 2),
    "stopped with the rear in the path of another": (60, 1000213, 1),
    "no place is free of all paths, but one is free while it is needed": (60, 1000245, 1),
    "stood longer than the stop was looked at": (60, 1000315, 5),
    "of two stops that both touch, the longer one": (60, 3000172, 3),
    "a stop that had begun was not made harder": (60, 4000108, 1),
    "went on from rest for a gap that was too short": (70, 1000210, 1),
    "waited with the nose in a lane that was still empty": (70, 1000049, 4),
    "found no stop, though a hard one keeps clear": (80, 1000140, 4),
    "counted on a delay of brakes that acted already": (61, 3000084, 4),
}


@pytest.mark.integration
@pytest.mark.parametrize(("seed", "scene", "proposal"), FOUND.values(), ids=FOUND)
def test_drive_that_once_ended_in_a_contact_touches_nobody(seed, scene, proposal):
    row = one(seed, scene, proposal)
    assert row is not None and row["driven"]
    assert "contact" not in row
