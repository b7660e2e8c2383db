"""What the road requires: sight, lanes and lines, lights and signs, queues, special scenes, and backing up."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.scene.base_model import FrozenModel


class SightPolicy(FrozenModel):
    """Sight of lanes in the ego's direction, ahead and behind: what is not seen is not free. Read by `sight`."""

    reacts_s: NonNegativeFloat = 0.5
    """Delay before a stop for what comes into sight: `PeoplePolicy.reaction_s`, since no human driver has to react."""
    margin_m: NonNegativeFloat = 1.0
    """Distance between the end of that stop and what comes into sight."""
    sampled_m: PositiveFloat = 4.0
    """A sight that ends within this distance of an object, or of a lane's end, ends there: stacks sample it in steps.
    """
    in_lane_m: NonNegativeFloat = 0.5
    """An object that reaches into a lane by more than this may block the sight of it."""
    seen_later_s: NonNegativeFloat = 1.0
    """Traffic that is more than this time away comes into sight while the entry can still be canceled. At more than
    20 km/h it is the time that a stop before the entry takes.
    """
    cyclist_mps: NonNegativeFloat = 6.0
    """Speed of traffic from behind at the roadside, where only cyclists come: a fast one in town."""


class LanePolicy(FrozenModel):
    """Borders, lines and the route. Read by `context`, `checks`, `rules`, `marking`, `traffic`, `aborts` and others."""

    drivable_tolerance_m: NonNegativeFloat = 0.15
    """The body may reach this far over the edge of the road: about half a tire."""
    tolerance_m: NonNegativeFloat = 0.1
    """A body this far over a border between lanes still counts as within its lane: the width of the line."""
    reaches_in_m: NonNegativeFloat = 0.05
    """The ego's body is inside a lane if it reaches in by more than this: half the line's width, to be safe."""
    further_out_m: NonNegativeFloat = 0.05
    """If it is already over an edge, it may go this much further out at most: as `ClearancePolicy.nearer_m`."""
    standing_edge_m: NonNegativeFloat = 0.3
    """A stopped ego may reach this far into an oncoming lane. Ours: oncoming traffic still has room beside it."""
    overrun_m: NonNegativeFloat = 0.3
    """A vehicle may come to rest this far beyond the end of its path: the accuracy of its stops and of its place."""
    zone_margin_m: NonNegativeFloat = 3.0
    """Distance from junctions and crossings within which no oncoming lane is used and no solid line crossed. Ours:
    traffic turns in there.
    """
    unknown_half_width_m: PositiveFloat = 2.0
    """Half the width of the route's lane if the map does not have it: a wide lane."""
    off_route_m: NonNegativeFloat = 200.0
    """Longest distance outside the route's own lane in one plan. The design's."""
    off_route_s: NonNegativeFloat = 60.0
    """Longest time outside it. The design's."""
    line_near_m: NonNegativeFloat = 2.0
    """Lines are checked this far before and after the crossing point: maps sample them every meter."""
    obstruction_behind_m: NonNegativeFloat = 1.0
    """An obstruction that justifies crossing a solid line is ahead of our bumper, or at most this far behind it, ..."""
    obstruction_ahead_m: NonNegativeFloat = 40.0
    """... and no further ahead than this. Ours: a recovery swings out within it."""
    beside_route_m: NonNegativeFloat = 1.0
    """An ego further than this from the route may return across a solid line without an obstruction."""
    solid_line_standing_s: NonNegativeFloat = 3.0
    """A stationary obstruction has been there for at least this long: `WaitLimits.hazard_or_parked_s`."""


class ControlPolicy(FrozenModel):
    """Lights and stop signs. Read by `checks`."""

    over_line_m: NonNegativeFloat = 1.0
    """A vehicle with its bumper up to this far past a light's stop line has not passed the light."""
    at_line_m: NonNegativeFloat = 6.0
    """A vehicle that has stopped within this distance of a line has stopped at it: first in line, a car's length."""
    same_line_m: NonNegativeFloat = 2.0
    """Lines closer together than this are the same line: the error between a map's line and a tracked pose."""
    creeps_past_m: NonNegativeFloat = 1.0
    """The ego creeps until its bumper is this far past the line."""


class QueuePolicy(FrozenModel):
    """How to tell a queue. Read by `obstacles`; `WaitLimits` says how long to wait."""

    parked_offset_m: NonNegativeFloat = 0.4
    """A vehicle further than this from the lane's center counts as parked."""
    in_line_m: NonNegativeFloat = 1.5
    """Vehicles whose centers are less than this apart laterally are in one line: less than a car's width."""
    unknown_m: NonNegativeFloat = 1.5
    """An object of unknown kind that is at least this long may be a vehicle: a little less than a bicycle."""
    reach_m: NonNegativeFloat = 15.0
    """A vehicle may be waiting for a light, line or vehicle within this distance ahead: two or three car lengths."""
    past_line_m: NonNegativeFloat = 2.0
    """Its front may be this far past the line of a light for which it is still waiting."""


class ScenePolicy(FrozenModel):
    """Flaggers, gates, school buses and emergency vehicles. Read by `rules`."""

    beside_m: NonNegativeFloat = 8.0
    """Objects within this lateral distance of the route belong to the scene: two lanes."""
    stands_mps: NonNegativeFloat = 0.5
    """A bus or emergency vehicle slower than this counts as stopped: `PredictionPolicy.along_mps`."""


class BackingPolicy(FrozenModel):
    """Backing up, and other moves in a direction that stacks do not watch. Read by `rules` and `backing`."""

    margin_m: NonNegativeFloat = 5.0
    """Sight required beyond the path: someone may come out of the unseen part."""
    closed_margin_m: NonNegativeFloat = 2.0
    """The same in front of a stopped vehicle that fills the lane: only that vehicle can come, it would have to set off
    first, and the ego stops within half a meter.
    """
    sight_ends_m: NonNegativeFloat = 1.1
    """A sight that ends within this distance of a vehicle ends at it: a little more than the sampling step of stacks.
    """
    look_m: NonNegativeFloat = 0.6
    """While it backs up, this much less sight is enough: sensors find its end a step nearer at one look than at the
    one before.
    """
    beside_m: NonNegativeFloat = 0.8
    """A vehicle fills the lane if it leaves less room than this on either side: no bicycle fits through, ..."""
    people_m: NonNegativeFloat = 3.0
    """... if no pedestrian or bicycle is nearer than this (ours: two seconds of walking), ..."""
    gentle_mps: NonNegativeFloat = 1.2
    """... and if the ego backs up no faster than this: walking speed."""
