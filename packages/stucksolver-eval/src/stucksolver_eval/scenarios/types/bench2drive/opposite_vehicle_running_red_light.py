"""OppositeVehicleRunningRedLight."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.opposite_vehicle import OppositeVehicle
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.junction_sites import ALL_WAYS, LIT, JunctionSites, direction_of
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class OppositeVehicleRunningRedLight(OppositeVehicle):
    """The hero's light is green, but an emergency vehicle runs a red light and crosses the hero's path."""

    type = "OppositeVehicleRunningRedLight"
    placed = SuitePlacement(
        "bench220", 1220, JunctionSites(ALL_WAYS, LIT, arms=4, extra=direction_of("opposite", "left", "right"))
    )
    driver_alone = "completed: brakes"
    needs_map = "a junction on the route (with lights, to be run) and a road from the side that `direction` names"
    signalized = True
