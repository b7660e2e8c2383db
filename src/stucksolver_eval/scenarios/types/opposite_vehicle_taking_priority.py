"""OppositeVehicleTakingPriority."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.opposite_vehicle import OppositeVehicle
from stucksolver_eval.scenarios.registry import scenario


@scenario
class OppositeVehicleTakingPriority(OppositeVehicle):
    """At a junction without lights an emergency vehicle crosses the hero's way without yielding."""

    type = "OppositeVehicleTakingPriority"
    needs_map = "a junction on the route with a road from the side that `direction` names"
