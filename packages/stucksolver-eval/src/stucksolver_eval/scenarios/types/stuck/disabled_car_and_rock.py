"""DisabledCarAndRock."""

from __future__ import annotations

from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.types.stuck.disabled_car_and_paper_bag import DisabledCarAndThing
from stucksolver_eval.sites.lane_requirements import right_of_two
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import IntegerDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class DisabledCarAndRock(DisabledCarAndThing):
    """A disabled car blocks the right lane, and a rock lies in the left: it cannot be driven over, so ask."""

    type = "DisabledCarAndRock"
    placed = SuitePlacement("immobilized", 3010, LaneSites(right_of_two), {"distance": IntegerDraw(40, 48)})
    driver_alone = "stuck behind the car"
    expected = "ask"
    suspends = frozenset({"blocked"})
    thing = "static.prop.rock"
    blueprints = (thing,)
