"""Requirements of the road: sight, lanes and lines, lights and signs, queues, special scenes, and backing up."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.scene.base_model import FrozenModel


class SightPolicy(FrozenModel):
    """Sight distance in lanes in the ego's direction, ahead and behind: occluded space counts as occupied.

    Read by `sight_distance`, `occluded_traffic` and `turn_around`.
    """

    reacts_s: NonNegativeFloat = 0.5
    """Delay before a stop for an object that becomes visible (s): `PeoplePolicy.reaction_s`, without a human driver."""
    margin_m: NonNegativeFloat = 1.0
    """Distance between the end of that stop and the object (m). Ours."""
    sampled_m: PositiveFloat = 4.0
    """Distance within which the end of the sight counts as that of an object or of the lane (m): stacks sample the
    sight distance in steps.
    """
    in_lane_m: NonNegativeFloat = 0.5
    """Reach of an object into a lane above which it may occlude the lane (m). Ours."""
    seen_later_s: NonNegativeFloat = 1.0
    """Time within which an occluded vehicle may still reach the entry (s). A later vehicle becomes visible while the
    entry can still be canceled. At more than 20 km/h it is the time that a stop before the entry takes.
    """
    cyclist_mps: NonNegativeFloat = 6.0
    """Speed of traffic from behind at the roadside, where only cyclists ride (m/s): a fast one in town."""


class LanePolicy(FrozenModel):
    """Borders, lines and the route. Read by most checks along a path."""

    drivable_tolerance_m: NonNegativeFloat = 0.15
    """Reach of the body over the edge of the road that is allowed (m): about half a tire."""
    tolerance_m: NonNegativeFloat = 0.1
    """Reach of a body over a border between lanes that still counts as within its lane (m): the width of the line."""
    reaches_in_m: NonNegativeFloat = 0.05
    """Reach into a lane above which the ego's body is inside it (m): half the line's width, to be safe."""
    further_out_m: NonNegativeFloat = 0.05
    """Greatest further reach of a body that is already over an edge (m): `ClearancePolicy.nearer_m`."""
    standing_edge_m: NonNegativeFloat = 0.3
    """Reach of a stopped ego into an oncoming lane that is allowed (m). Ours: oncoming traffic can still pass."""
    overrun_m: NonNegativeFloat = 0.3
    """Distance beyond the end of its path at which a vehicle may stop (m): the accuracy of its stops and pose."""
    zone_margin_m: NonNegativeFloat = 3.0
    """Distance from junctions and crossings within which no oncoming lane is used and no solid line is crossed (m).
    Ours: traffic turns in there.
    """
    unknown_half_width_m: PositiveFloat = 2.0
    """Half the width of the route's lane if the map does not have it (m): a wide lane."""
    off_route_m: NonNegativeFloat = 200.0
    """Longest distance outside the route's own lane in one plan (m). The design's."""
    off_route_s: NonNegativeFloat = 60.0
    """Longest time outside the route's own lane in one plan (s). The design's."""
    line_near_m: NonNegativeFloat = 2.0
    """Distance before and after a crossing point within which lines are checked (m): maps sample them every meter."""
    obstruction_behind_m: NonNegativeFloat = 1.0
    """Distance behind the ego's bumper up to which an obstruction justifies crossing a solid line (m). Ours."""
    obstruction_ahead_m: NonNegativeFloat = 40.0
    """Distance ahead up to which an obstruction justifies crossing a solid line (m). Ours: room for a recovery."""
    beside_route_m: NonNegativeFloat = 1.0
    """Distance from the route above which the ego may return across a solid line without an obstruction (m). Ours."""
    solid_line_standing_s: NonNegativeFloat = 3.0
    """Least time for which an obstruction has been stationary (s): `WaitLimits.hazard_or_parked_s`."""


class ControlPolicy(FrozenModel):
    """Lights and stop signs. Read by `path_checks` and the solver."""

    over_line_m: NonNegativeFloat = 1.0
    """Distance of the bumper past a light's stop line up to which the light is not passed yet (m). Ours."""
    at_line_m: NonNegativeFloat = 6.0
    """Distance to a line within which a stopped vehicle has stopped at it (m): first in line, a car's length."""
    same_line_m: NonNegativeFloat = 2.0
    """Distance below which two lines are the same (m): the error between a map's line and a tracked pose."""
    creeps_past_m: NonNegativeFloat = 1.0
    """Distance of the bumper past the line up to which the ego creeps (m). Ours."""


class QueuePolicy(FrozenModel):
    """Signs of a queue. Read by `passable_obstacles`; `WaitLimits` has the durations of waits."""

    parked_offset_m: NonNegativeFloat = 0.4
    """Offset from the lane's center above which a vehicle counts as parked (m). Ours."""
    in_line_m: NonNegativeFloat = 1.5
    """Lateral distance between centers below which vehicles are in one line (m): less than a car's width."""
    unknown_m: NonNegativeFloat = 1.5
    """Least length of an object of unknown kind that may be a vehicle (m): a little less than a bicycle."""
    reach_m: NonNegativeFloat = 15.0
    """Distance to a light, line or vehicle for which a vehicle may be waiting (m): two or three car lengths."""
    past_line_m: NonNegativeFloat = 2.0
    """Distance of its front past the line of a light for which it may still be waiting (m). Ours."""


class ScenePolicy(FrozenModel):
    """Flaggers, gates, school buses and emergency vehicles. Read by `traffic_rules`."""

    beside_m: NonNegativeFloat = 8.0
    """Lateral distance from the route within which objects belong to the scene (m): two lanes."""
    stands_mps: NonNegativeFloat = 0.5
    """Speed below which a bus or emergency vehicle counts as stopped (m/s): `PredictionPolicy.along_mps`."""


class BackingPolicy(FrozenModel):
    """Backing up. Read by `back_up` and `leaving`."""

    margin_m: NonNegativeFloat = 5.0
    """Sight distance required beyond the path (m): a road user may come out of occluded space. Ours."""
    far_m: NonNegativeFloat = 8.0
    """Length of the path above which traffic from beyond the sight must be able to stop behind the ego (m). Ours: room
    for a recovery, about as far as the ego's own length and a half.
    """
    closed_margin_m: NonNegativeFloat = 2.0
    """The same in front of a stopped vehicle that fills the lane (m). Only that vehicle can approach, after setting
    off, and the ego stops within half a meter.
    """
    sight_ends_m: NonNegativeFloat = 1.1
    """Distance to a vehicle within which the sight ends at that vehicle (m): just over the sampling step of stacks."""
    look_m: NonNegativeFloat = 0.6
    """Decrease of the sight distance that is allowed while the ego backs up (m): sensors may report the end of the
    sight one sampling step nearer than on the tick before.
    """
    beside_m: NonNegativeFloat = 0.8
    """Gap on either side below which a vehicle fills the lane (m): no bicycle fits through."""
    people_m: NonNegativeFloat = 3.0
    """Distance within which a pedestrian or cyclist rules out a filled lane (m). Ours: two seconds of walking."""
    gentle_mps: NonNegativeFloat = 1.2
    """Highest speed of the ego for which a filled lane counts (m/s): walking speed."""
