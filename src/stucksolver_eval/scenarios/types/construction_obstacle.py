"""ConstructionObstacle."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.obstacle import ConstructionSite
from stucksolver_eval.scenarios.parameters import Number
from stucksolver_eval.scenarios.registry import scenario


@scenario
class ConstructionObstacle(ConstructionSite):
    """A construction site with cones closes the hero's lane; it must change to the lane beside."""

    type = "ConstructionObstacle"
    starts = "the site rises at the trigger; the traffic beside slows 5 s after the hero came within 30 m"
    distance_m = Number("distance", 100.0, "m")
