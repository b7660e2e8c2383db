"""What the road asks for: sight, lanes and their lines, lights and signs, queues, scenes, and ways back."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.scene.model import Model


class SightPolicy(Model):
    """Lanes of our own direction, ahead and behind: what is not seen is not free. Read by `sight`."""

    reacts_s: NonNegativeFloat = 0.5
    """Driving on sight: a stop begins so much later: `PeoplePolicy.reaction_s`, no human reacts."""
    margin_m: NonNegativeFloat = 1.0
    """And ends so much before what comes into sight."""
    sampled_m: PositiveFloat = 4.0
    """A sight that ends nearer to an object, or to a lane's end, ends there: stacks look every so many metres."""
    in_lane_m: NonNegativeFloat = 0.5
    """What reaches into a lane by more may end the sight of it."""
    seen_later_s: NonNegativeFloat = 1.0
    """Who is further off than they drive in that time before our entry comes into sight while it can be left be."""
    behind_most_m: NonNegativeFloat = 50.0
    """No more need be seen behind: stacks know about 60 m of their road there."""
    cyclist_mps: NonNegativeFloat = 6.0
    """Where only cyclists come from behind, at the roadside: a quick one in town."""


class LanePolicy(Model):
    """Borders, lines and the route. Read by `case`, `checks`, `rules`, `marking`, `traffic`, `aborts` and `guard`."""

    drivable_tolerance_m: NonNegativeFloat = 0.15
    """So far may the body reach over the edge of the road: about half a tyre."""
    tolerance_m: NonNegativeFloat = 0.1
    """So far over a border between lanes, a body still counts as within its lane: the width of the line."""
    reaches_in_m: NonNegativeFloat = 0.05
    """Our body is inside a lane when it reaches in by more: half the line's width, on the safe side of the above."""
    further_out_m: NonNegativeFloat = 0.05
    """Over an edge already, it may go out no further than by this: as `ClearancePolicy.nearer_m`."""
    standing_edge_m: NonNegativeFloat = 0.3
    """Standing, it may reach so far into an oncoming lane without being in it. Ours: who comes has room beside it."""
    zone_margin_m: NonNegativeFloat = 3.0
    """An oncoming lane and a solid line are used no nearer to junctions and crossings. Ours: those turn in there."""
    unknown_half_width_m: PositiveFloat = 2.0
    """Of the route's lane where the map has none: that of a wide lane."""
    off_route_m: NonNegativeFloat = 200.0
    """At most so far outside the route's own lane in one plan. The design's."""
    off_route_s: NonNegativeFloat = 60.0
    """And for so long. The design's."""
    line_near_m: NonNegativeFloat = 2.0
    """Lines are looked at so far before and behind the place where they are crossed: maps sample them by the metre."""
    obstruction_behind_m: NonNegativeFloat = 1.0
    """An obstruction for which a solid line is crossed is before our bumper, or no more than this behind it, ..."""
    obstruction_ahead_m: NonNegativeFloat = 40.0
    """... and nearer than this ahead. Ours: a recovery swings out within it."""
    beside_route_m: NonNegativeFloat = 1.0
    """Further beside the route, the ego may come back over a solid line with nothing in its way."""
    solid_line_standing_s: NonNegativeFloat = 3.0
    """A stationary obstruction has stood for so long: `WaitLimits.hazard_or_parked_s`."""


class ControlPolicy(Model):
    """Lights and stop signs. Read by `checks`."""

    over_line_m: NonNegativeFloat = 1.0
    """A vehicle that stands with its bumper this far past a light's line has not passed the light."""
    at_line_m: NonNegativeFloat = 6.0
    """A vehicle that stands no further than this before a line has stopped at it: first in line, a car's length."""
    same_line_m: NonNegativeFloat = 2.0
    """A line seen so near to where one was is the same: what a map's line and a tracked pose differ by."""
    creeps_past_m: NonNegativeFloat = 1.0
    """It creeps until the bumper is so far over the line."""


class QueuePolicy(Model):
    """Who only waits. Read by `obstacles`; how long is a matter of `WaitLimits`."""

    parked_offset_m: NonNegativeFloat = 0.4
    """A vehicle this far from the lane's centre stands as parked ones do."""
    in_line_m: NonNegativeFloat = 1.5
    """Vehicles whose centres are offset by less stand in one line: less than a car's width."""
    reach_m: NonNegativeFloat = 15.0
    """A light, line or standing vehicle this near ahead may be what a vehicle waits for: two or three car lengths."""
    past_line_m: NonNegativeFloat = 2.0
    """Its front may be so far over the line of a light that it still waits for."""


class ScenePolicy(Model):
    """Flaggers, gates, school buses and emergency vehicles. Read by `rules`."""

    beside_m: NonNegativeFloat = 8.0
    """What stands this near to the way belongs to its scene: two lanes."""
    stands_mps: NonNegativeFloat = 0.5
    """Slower, a bus or an emergency vehicle stands: `PredictionPolicy.along_mps`."""


class BackingPolicy(Model):
    """Backing up, and other ways where a driver does not look by habit. Read by `rules`."""

    margin_m: NonNegativeFloat = 5.0
    """Seen beyond what is driven: somebody may come out of what is not seen."""
    closed_margin_m: NonNegativeFloat = 2.0
    """The same before a standing vehicle that fills the lane: only it can come, it would have to set off, and the ego
    stops within half a metre."""
    sight_ends_m: NonNegativeFloat = 1.1
    """A sight that ends no further from a vehicle ends at it: what stacks sample it by, and a little."""
    beside_m: NonNegativeFloat = 0.8
    """A vehicle fills the lane that leaves less than this on either side: nobody rides through."""
    people_m: NonNegativeFloat = 3.0
    """And has nobody on foot or a bicycle so near. Ours: two seconds of walking."""
    gentle_mps: NonNegativeFloat = 1.2
    """And the ego backs up no quicker: walking speed."""
