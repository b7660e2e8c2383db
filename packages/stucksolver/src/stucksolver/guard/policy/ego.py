"""What the ego may do, how it keeps to a path, and how it ends a plan."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.scene.base_model import FrozenModel


class TurningPolicy(FrozenModel):
    """A turn in several legs. Read by `turning`."""

    edge_m: NonNegativeFloat = 0.15
    """Distance of every corner of the body from the edges of the road: `LanePolicy.drivable_tolerance_m`, but inwards,
    since the corners swing out in a turn.
    """
    error_m: PositiveFloat = 0.35
    """The turn stops if the ego is further than this from the proven leg: the gaps cover this and `error_rad`."""
    error_rad: PositiveFloat = 0.2
    """It also stops at a larger heading error than this."""
    shifts_s: NonNegativeFloat = 1.5
    """Time between two legs, to change gear and to check the next leg. Ours."""
    slowest_mps: PositiveFloat = 0.6
    """Lowest average speed of a leg, stops and starts included. Measured on carlette: 0.65 to 0.8 m/s if 1.4 m/s was
    requested.
    """


class SpeedPolicy(FrozenModel):
    """Caps on the speed that a plan asks for. Read by `caps`, `checks`, `rules`, `marking`, `oncoming` and `guard`."""

    recovery_mps: PositiveFloat = 20 / 3.6
    """For a plan that nobody asked for. The design's."""
    passing_mps: PositiveFloat = 40 / 3.6
    """For a pass through the oncoming lane, if the limits of its lanes allow it: the same as `guided_mps`."""
    people_aside_m: NonNegativeFloat = 3.0
    """If people or two-wheelers are nearer than this, `recovery_mps` is the cap: two seconds of walking."""
    doors_aside_m: NonNegativeFloat = 1.1
    """The same for the doors of stationary vehicles: `DoorPolicy.reach_m`, plus 0.2 m to the open door."""
    guided_mps: PositiveFloat = 40 / 3.6
    """For overtaking that a passenger asked for, if the limits of its lanes allow it. The design's."""
    creep_mps: PositiveFloat = 8 / 3.6
    """The highest speed that still counts as walking pace. The design's."""
    tolerance_mps: NonNegativeFloat = 1.0
    """A plan ends if the ego exceeds the cap by more than this: more than a speed controller overshoots."""


class TrackingPolicy(FrozenModel):
    """How the vehicle drives a path from its real position and heading.

    Read by `tracking`, `early_return` and `guard`.
    """

    error_m: NonNegativeFloat = 0.9
    """A plan ends if the ego is further from its path than this: half a car's width."""
    askew_rad: NonNegativeFloat = 0.1
    """Below this heading error the vehicle counts as aligned with its path and need not steer onto it first."""
    parallel_rad: NonNegativeFloat = 0.01
    """Below this angle to the road a path counts as parallel to what it passes: 1 cm of offset on each meter."""
    beside_m: NonNegativeFloat = 0.05
    """Below this lateral error the vehicle counts as on its path: the accuracy of localization."""
    drift_mps: NonNegativeFloat = 0.25
    """The highest sideways speed in a tracking fault. Ours: 3 degrees off the path at 20 km/h. A plan begins only if
    its gaps allow for such a fault until the vehicle has stopped; at walking pace `ClearancePolicy` is enough.
    """
    kept_s: NonNegativeFloat = 1.0
    """A tracking error is assumed to persist for this long plus the braking time, because its cause may persist."""
    worked_off_m: PositiveFloat = 6.0
    """Distance over which it is then corrected: about two wheelbases."""
    settles_m: PositiveFloat = 20.0
    """An askew start is simulated for at most this distance."""
    lock_m: PositiveFloat = 1.5
    """Distance over which the wheels turn from straight ahead to full lock: a second at a creep."""
    straightens_m: PositiveFloat = 3.0
    """When backing up, a heading error decays over this distance: about a wheelbase."""
    reach_m: PositiveFloat = 2.0
    """The body's center returns to the path over about this distance. Ours."""
    approach_rad: NonNegativeFloat = 0.45
    """The steepest angle at which it approaches the path. Ours."""


class StoppingPolicy(FrozenModel):
    """Stops that end a plan or let others pass. Read by `aborts` and `ways_out`; `rests_mps` also by `checks`."""

    every_m: PositiveFloat = 3.0
    """Distance between the stops that are checked: less than a car's length, so that no car fits between two."""
    lag_s: NonNegativeFloat = 0.3
    """From the command to brake until the brakes act. Ours: a hydraulic brake, and one or two ticks of the loop."""
    gives_way_s: NonNegativeFloat = 2.5
    """The ego gives way to traffic that it would hit within its braking time plus this time. Ours: deliberately
    late, since many turn off before.
    """
    goes_on_s: NonNegativeFloat = 6.0
    """It keeps giving way until it would hit nobody within this time: the gap in which drivers cross a road."""
    yields_ahead_m: NonNegativeFloat = 2.0
    """An ego that gives way goes on only if the path of traffic that it would meet begins further ahead than this: less
    than half a car's length, so that it does not set off and stop again on the way to that path.
    """
    place_every_m: PositiveFloat = 0.5
    """Distance between the places to yield at that are compared with the paths of others: a station of the path."""
    places_ahead_m: PositiveFloat = 25.0
    """Places to yield at are looked for over this distance: the width of a large junction, a bound on the work."""
    nose_in_junction_m: NonNegativeFloat = 3.5
    """A vehicle whose nose is no further inside a junction than this (m), a lane's width, yields as early as it can."""
    stands_s: NonNegativeFloat = 3.0
    """Time after the stop for which it is checked: later checks cover what follows."""
    past_end_m: NonNegativeFloat = 0.5
    """Distance beyond the stop for which it is checked: one station of the path."""
    rests_mps: NonNegativeFloat = 0.3
    """Below this speed the ego counts as stopped: it can choose whether to set off, and has stopped at a line ahead."""
    return_least_mps: PositiveFloat = 3.0
    """A path back into the lane is planned for at least this speed, ..."""
    return_s: NonNegativeFloat = 2.0
    """... for this duration, that of a brisk lane change, ..."""
    return_least_m: PositiveFloat = 4.0
    """... and for at least this length, a car's length."""


class HarmPolicy(FrozenModel):
    """The least harmful option after the commit point. Read by `ways_out`; `touch_m` also by `aborts` and `predict`."""

    touch_m: NonNegativeFloat = 0.1
    """A smaller gap counts as contact: perception is no more accurate than that."""
    gentler_mps: NonNegativeFloat = 1.0
    """A stop must lower the impact speed by more than this. A smaller gain is uncertain, and driving on clears the
    road sooner.
    """


class HandBackPolicy(FrozenModel):
    """Whether the stack may drive on by itself where a plan or a stop has ended. Read by `hand_back`."""

    askew_rad: NonNegativeFloat = 0.2
    """With a smaller heading error and ..."""
    aside_m: NonNegativeFloat = 0.4
    """... a smaller lateral offset, the ego counts as being in its lane: its stack sees what is ahead of it."""
    kept_m: NonNegativeFloat = 0.1
    """Gap to stationary objects on the tightest path back: `HarmPolicy.touch_m`, since stacks keep more by themselves.
    """
    most_turn_rad: PositiveFloat = 1.3
    """A larger heading error is treated as this one: beyond it no arc runs along the road."""
    speed_mps: PositiveFloat = 2.0
    """Speed on that path."""
    own_s: PositiveFloat = 1.0
    """A stopped vehicle is handed back only if its driver touches nothing within this time. Ours: a reaction time.
    """
    check_s: PositiveFloat = 0.2
    """After a hand-back the guard brakes if braking this much later would touch something. Ours: a few ticks of a slow
    stack, so that a late tick does not matter.
    """
    step_s: PositiveFloat = 0.05
    """Time between the instants that are compared: 0.2 m at 4 m/s. Ours."""
