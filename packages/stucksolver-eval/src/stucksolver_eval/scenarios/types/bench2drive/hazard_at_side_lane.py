"""HazardAtSideLane."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.obstacle import SlowBicycles
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import left_lane
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.parameter_draws import IntegerDraw, RideDistanceDraw
from stucksolver_eval.sites.suite_placement import SuitePlacement


@scenario
class HazardAtSideLane(SlowBicycles):
    """Two slow bicycles ride at the edge of the hero's lane; it passes them partly in the adjacent lane."""

    type = "HazardAtSideLane"
    placed = SuitePlacement(
        "bench220",
        1100,
        LaneSites(left_lane, 150),
        {
            "distance": IntegerDraw(41, 45),
            "speed": IntegerDraw(30, 60),
            "bicycle_drive_distance": RideDistanceDraw(40, 150),
            "bicycle_speed": IntegerDraw(6, 12),
        },
        only_in="grid_town",
    )
    driver_alone = "stuck behind the bicycles when they stop"
    starts = "the bicycles start at the trigger"
