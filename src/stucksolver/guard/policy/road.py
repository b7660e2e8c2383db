"""What the road requires: sight, lanes and their lines, lights and signs, queues, scenes, and ways back."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.scene.model import Model


class SightPolicy(Model):
    """Lanes of our own direction, ahead and behind: what is not seen is not free. Read by `sight`."""

    reacts_s: NonNegativeFloat = 0.5
    """Delay of a stop when driving on sight: `PeoplePolicy.reaction_s`, no human reacts."""
    margin_m: NonNegativeFloat = 1.0
    """Distance at which it ends before what comes into sight."""
    sampled_m: PositiveFloat = 4.0
    """A sight that ends nearer than this to an object, or to a lane's end, ends there: stacks sample it in steps."""
    in_lane_m: NonNegativeFloat = 0.5
    """An object that reaches into a lane by more than this may end the sight of it."""
    seen_later_s: NonNegativeFloat = 1.0
    """Traffic further away than its way in this time comes into sight while the entry can still be cancelled."""
    behind_most_m: NonNegativeFloat = 50.0
    """No more sight is required behind: stacks know about 60 m of their road there."""
    cyclist_mps: NonNegativeFloat = 6.0
    """Speed if only cyclists come from behind, at the roadside: a fast one in town."""


class LanePolicy(Model):
    """Borders, lines and the route. Read by `case`, `checks`, `rules`, `marking`, `traffic`, `aborts` and `guard`."""

    drivable_tolerance_m: NonNegativeFloat = 0.15
    """The body may reach this far over the edge of the road: about half a tyre."""
    tolerance_m: NonNegativeFloat = 0.1
    """This far over a border between lanes, a body still counts as within its lane: the width of the line."""
    reaches_in_m: NonNegativeFloat = 0.05
    """Our body is inside a lane if it reaches in by more: half the line's width, on the safe side of the above."""
    further_out_m: NonNegativeFloat = 0.05
    """If already over an edge, it may go out no further than this: as `ClearancePolicy.nearer_m`."""
    standing_edge_m: NonNegativeFloat = 0.3
    """Standing, it may reach this far into an oncoming lane without being in it. Ours: traffic has room beside it."""
    zone_margin_m: NonNegativeFloat = 3.0
    """An oncoming lane and a solid line are used no nearer than this to junctions and crossings. Ours: traffic
    turns in there.
    """
    unknown_half_width_m: PositiveFloat = 2.0
    """Half width of the route's lane if the map has none: that of a wide lane."""
    off_route_m: NonNegativeFloat = 200.0
    """Longest distance outside the route's own lane in one plan. The design's."""
    off_route_s: NonNegativeFloat = 60.0
    """Longest time outside it. The design's."""
    line_near_m: NonNegativeFloat = 2.0
    """Lines are checked this far before and behind the crossing point: maps sample them by the metre."""
    obstruction_behind_m: NonNegativeFloat = 1.0
    """An obstruction that justifies crossing a solid line is ahead of our bumper, or at most this far behind it, ..."""
    obstruction_ahead_m: NonNegativeFloat = 40.0
    """... and nearer than this ahead. Ours: a recovery swings out within it."""
    beside_route_m: NonNegativeFloat = 1.0
    """Further than this beside the route, the ego may return over a solid line with nothing in its way."""
    solid_line_standing_s: NonNegativeFloat = 3.0
    """A stationary obstruction has stood this long: `WaitLimits.hazard_or_parked_s`."""


class ControlPolicy(Model):
    """Lights and stop signs. Read by `checks`."""

    over_line_m: NonNegativeFloat = 1.0
    """A vehicle that stands with its bumper this far past a light's line has not passed the light."""
    at_line_m: NonNegativeFloat = 6.0
    """A vehicle that stands at most this far before a line has stopped at it: first in line, a car's length."""
    same_line_m: NonNegativeFloat = 2.0
    """Two lines this close are the same one: the difference between a map's line and a tracked pose."""
    creeps_past_m: NonNegativeFloat = 1.0
    """The ego creeps until its bumper is this far over the line."""


class QueuePolicy(Model):
    """Vehicles that only wait. Read by `obstacles`; `WaitLimits` says for how long."""

    parked_offset_m: NonNegativeFloat = 0.4
    """A vehicle this far from the lane's centre stands like a parked one."""
    in_line_m: NonNegativeFloat = 1.5
    """Vehicles whose centres differ by less stand in one line: less than a car's width."""
    reach_m: NonNegativeFloat = 15.0
    """A light, line or standing vehicle this near ahead may be what a vehicle waits for: two or three car lengths."""
    past_line_m: NonNegativeFloat = 2.0
    """Its front may be this far over the line of a light that it still waits for."""


class ScenePolicy(Model):
    """Flaggers, gates, school buses and emergency vehicles. Read by `rules`."""

    beside_m: NonNegativeFloat = 8.0
    """Objects this near to the path belong to its scene: two lanes."""
    stands_mps: NonNegativeFloat = 0.5
    """A slower bus or emergency vehicle stands: `PredictionPolicy.along_mps`."""


class BackingPolicy(Model):
    """Backing up, and other moves where a driver does not look by habit. Read by `rules`."""

    margin_m: NonNegativeFloat = 5.0
    """Sight required beyond the path: someone may come out of what is not seen."""
    closed_margin_m: NonNegativeFloat = 2.0
    """The same before a standing vehicle that fills the lane: only that vehicle can come, it would have to set
    off, and the ego stops within half a metre.
    """
    sight_ends_m: NonNegativeFloat = 1.1
    """A sight that ends no further from a vehicle ends at it: the sampling step of stacks, and a little."""
    beside_m: NonNegativeFloat = 0.8
    """A vehicle fills the lane if it leaves less than this on either side: nobody rides through."""
    people_m: NonNegativeFloat = 3.0
    """And if no pedestrian or bicycle is this near. Ours: two seconds of walking."""
    gentle_mps: NonNegativeFloat = 1.2
    """And if the ego backs up no faster: walking speed."""
