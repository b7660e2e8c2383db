"""OppositeVehicleRunningRedLight."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.opposite_vehicle import OppositeVehicle
from stucksolver_eval.scenarios.registry import scenario


@scenario
class OppositeVehicleRunningRedLight(OppositeVehicle):
    """The hero's light is green, but an emergency vehicle runs its red one and crosses the hero's way."""

    type = "OppositeVehicleRunningRedLight"
    needs_map = "a junction on the route (with lights, to be run) and a road from the side that `direction` names"
    signalized = True
