"""RocksAcrossRoad."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.lane_places import row_across
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.scenarios.types.stuck.closed_road import ClosedRoad

ROCK = "static.prop.rock"


@scenario
class RocksAcrossRoad(ClosedRoad):
    """Rocks lie from curb to curb after a rockslide, without a sign: a person recognizes that the road is closed."""

    type = "RocksAcrossRoad"
    placed = None
    driver_alone = "stuck before the rocks"
    blueprints = (ROCK,)

    def stage(self) -> None:
        for place in row_across(self.setting.map, self.ahead(self.distance_m)):
            self.cast.must_spawn(ROCK, place, lift_m=0.0)
