"""HazardAtSideLane."""

from __future__ import annotations

from stucksolver_eval.scenarios.families.obstacle import SlowBicycles
from stucksolver_eval.scenarios.registry import scenario
from stucksolver_eval.sites.lane_requirements import left_lane
from stucksolver_eval.sites.lane_sites import Along
from stucksolver_eval.sites.parameter_draws import Ride, Value
from stucksolver_eval.sites.suite_placement import Placed


@scenario
class HazardAtSideLane(SlowBicycles):
    """Two slow bicycles ride at the edge of the hero's lane; it passes them partly in the adjacent lane."""

    type = "HazardAtSideLane"
    placed = Placed(
        "bench220",
        1100,
        Along(left_lane, 150),
        {
            "distance": Value(41, 45),
            "speed": Value(30, 60),
            "bicycle_drive_distance": Ride(40, 150),
            "bicycle_speed": Value(6, 12),
        },
        only_in="grid_town",
    )
    driver_alone = "stuck behind the bicycles once they stop"
    starts = "the bicycles start at the trigger"
