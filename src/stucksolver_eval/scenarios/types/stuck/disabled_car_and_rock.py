"""DisabledCarAndRock."""

from __future__ import annotations

from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.types.stuck.disabled_car_and_paper_bag import DisabledCarAndThing


@scenario
class DisabledCarAndRock(DisabledCarAndThing):
    """A disabled car blocks the right lane, a rock lies in the left one: nobody may drive over it, so ask."""

    type = "DisabledCarAndRock"
    expected = "ask"
    thing = "static.prop.rock"
    blueprints = (thing,)
