"""HazardAtSideLane."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.obstacle import SlowBicycles
from stucksolver_eval.scenarios.registry import scenario


@scenario
class HazardAtSideLane(SlowBicycles):
    """Two slow bicycles at the edge of the hero's lane; it passes them partly in the lane beside."""

    type = "HazardAtSideLane"
    starts = "the bicycles set off at the trigger"
