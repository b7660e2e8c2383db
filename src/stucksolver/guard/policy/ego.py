"""What the ego may do, how it keeps to a path, and how it ends a plan."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.scene.model import Model


class SpeedPolicy(Model):
    """Caps on the speed that a plan asks for. Read by `caps`, `checks`, `rules`, `marking`, `oncoming` and `guard`."""

    recovery_mps: PositiveFloat = 20 / 3.6
    """For a plan of our own. The design's."""
    passing_mps: PositiveFloat = 40 / 3.6
    """For a pass through the oncoming lane, if the limits of both lanes allow it: the same as `guided_mps`."""
    people_aside_m: NonNegativeFloat = 3.0
    """With people or two-wheelers nearer than this a pass stays at `recovery_mps`: two seconds of walking."""
    doors_aside_m: NonNegativeFloat = 1.1
    """The same for the doors of vehicles: `DoorPolicy.reach_m`, and 0.2 m to the open door."""
    guided_mps: PositiveFloat = 40 / 3.6
    """For overtaking that a passenger asked for. The design's."""
    creep_mps: PositiveFloat = 8 / 3.6
    """Walking pace: the highest speed that still counts as one. The design's."""
    tolerance_mps: NonNegativeFloat = 1.0
    """A plan ends if the cap is exceeded by this much: above the overshoot of a speed controller."""


class TrackingPolicy(Model):
    """How the vehicle drives a path from its real position and heading. Read by `tracking` and `guard`."""

    error_m: NonNegativeFloat = 0.9
    """A plan ends if the ego is further beside its path: half a car's width."""
    askew_rad: NonNegativeFloat = 0.1
    """Below this heading error the vehicle counts as aligned with its path and need not steer onto it first."""
    beside_m: NonNegativeFloat = 0.05
    """Below this lateral error the vehicle counts as on its path: the accuracy of localisation."""
    drift_mps: NonNegativeFloat = 0.25
    """The highest sideways speed of a fault. Ours: 3 degrees off the path at 20 km/h. A plan begins only with
    gaps that allow for it until the vehicle stands; at walking pace the gaps of `ClearancePolicy` are enough.
    """
    kept_s: NonNegativeFloat = 1.0
    """A tracking error is assumed to last this long beyond a stop, because its cause may last."""
    worked_off_m: PositiveFloat = 6.0
    """After that it is corrected over this distance: about two wheelbases."""
    settles_m: PositiveFloat = 20.0
    """An askew start is followed for this distance."""
    lock_m: PositiveFloat = 1.5
    """The wheels turn from straight to their lock over this distance: a second at creeping speed."""
    straightens_m: PositiveFloat = 3.0
    """When backing up, a heading error fades over this distance: about a wheelbase."""
    reach_m: PositiveFloat = 2.0
    """The centre returns to the path over about this distance. Ours."""
    approach_rad: NonNegativeFloat = 0.45
    """It approaches the path at no steeper angle. Ours."""


class StoppingPolicy(Model):
    """Stops that end a plan or let others pass. Read by `aborts` and `ways_out`; `rests_mps` also by `checks`."""

    every_m: PositiveFloat = 3.0
    """Distance between the stops that are tried: less than a car's length, so that no car fits between two of them."""
    lag_s: NonNegativeFloat = 0.3
    """From the order to brake until the brakes act. Ours: a hydraulic brake, and a tick or two of the loop."""
    gives_way_s: NonNegativeFloat = 2.5
    """The ego gives way to those it would meet within this time after a stop. Ours: late, since many turn off
    before.
    """
    goes_on_s: NonNegativeFloat = 6.0
    """It keeps giving way until it would meet nobody within this time: the gap that drivers accept to cross a road."""
    stands_s: NonNegativeFloat = 3.0
    """The stop is checked for this long: until the next check finds the same."""
    past_end_m: NonNegativeFloat = 0.5
    """And this far beyond its end: one station of the path."""
    rests_mps: NonNegativeFloat = 0.3
    """Below this speed the ego is at rest: setting off is then a choice, and a line ahead counts as stopped at."""
    return_least_mps: PositiveFloat = 3.0
    """A way back into the lane is planned for at least this speed, ..."""
    return_s: NonNegativeFloat = 2.0
    """... for this duration, a brisk lane change, ..."""
    return_least_m: PositiveFloat = 4.0
    """... and for at least this length, a car's length."""


class HarmPolicy(Model):
    """The way out with the least harm after the commit point. Read by `ways_out`."""

    touch_m: NonNegativeFloat = 0.1
    """A smaller gap counts as contact: perception is not more accurate."""
    gentler_mps: NonNegativeFloat = 1.0
    """A stop must lower the impact speed by more than this. A smaller gain is uncertain, and driving on clears
    the way sooner.
    """


class HandBackPolicy(Model):
    """Whether the stack may drive on by itself from where a plan was given up. Read by `hand_back`."""

    askew_rad: NonNegativeFloat = 0.2
    """With a smaller heading error and ..."""
    aside_m: NonNegativeFloat = 0.4
    """... a smaller lateral offset, a vehicle is in its lane: what is ahead of it is ahead of its driver."""
    kept_m: NonNegativeFloat = 0.1
    """Kept from standing objects on the tightest way back: `HarmPolicy.touch_m`, since drivers keep more."""
    most_turn_rad: PositiveFloat = 1.3
    """A larger heading error is treated as this one: beyond it no arc leads along the road."""
    speed_mps: PositiveFloat = 2.0
    """Speed on that way."""
