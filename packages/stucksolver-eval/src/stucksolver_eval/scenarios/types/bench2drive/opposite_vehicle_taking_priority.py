"""OppositeVehicleTakingPriority."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.opposite_vehicle import OppositeVehicle
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import ALL_WAYS, UNLIT, JunctionSites, direction_of
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class OppositeVehicleTakingPriority(OppositeVehicle):
    """At a junction without lights, an emergency vehicle crosses the hero's path without yielding."""

    type = "OppositeVehicleTakingPriority"
    placed = SuitePlacement("bench220", 1230, JunctionSites(ALL_WAYS, UNLIT, extra=direction_of("right", "left")))
    driver_alone = "collision: already in the junction when the vehicle arrives"
    needs_map = "a junction on the route with a road from the side that `direction` names"
