"""Left and right, the map's origin and the order of a list make no difference, in scenes of the oracle."""

from __future__ import annotations

import math
import os

import pytest

from alike import comparing
from lab.benchmarks.guard_oracle.campaign import proposals_of
from lab.benchmarks.guard_oracle.drive import drive, judged

SCENES = int(os.environ.get("GUARD_SCENES", "160"))
"""From 80 on each of the oracle's 16 classes of scenes is there five times and more."""
SEED, QUICK, LOOKS = 43, 4, 6
"""The first `QUICK` scenes belong to the unit tests; every sixth look of a drive is compared."""


@pytest.mark.parametrize(
    "number", [pytest.param(n, marks=() if n < QUICK else pytest.mark.integration) for n in range(SCENES)]
)
def test_guard_mirrored_shifted_or_reordered_scene_has_same_verdict(number):
    """Left and right, the origin and the order of objects make no difference."""
    for k, proposal in proposals_of(SEED, number):
        if proposal.plan.behaviors[0].stands_still:
            continue
        with comparing(every=LOOKS) as found:
            execution, verdict = judged(proposal.world, proposal.plan, proposal.guided)
            if verdict.accepted and (number + k) % 2 == 0:
                drive(proposal.world, execution, math.inf)
        assert found == []
