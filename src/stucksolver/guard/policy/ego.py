"""What the ego may do, how it keeps to a path, and how it ends a plan."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.scene.model import Model


class SpeedPolicy(Model):
    """Caps on what a plan asks for. Read by `caps`, `checks`, `rules`, `marking`, `oncoming` and `guard`."""

    recovery_mps: PositiveFloat = 20 / 3.6
    """Of a plan of our own. The design's."""
    passing_mps: PositiveFloat = 40 / 3.6
    """Of a pass through the oncoming lane, where both lanes' limits allow it: that of `guided_mps`."""
    people_aside_m: NonNegativeFloat = 3.0
    """With people or two-wheelers nearer than this a pass is no quicker than `recovery_mps`: two seconds of walking."""
    doors_aside_m: NonNegativeFloat = 1.1
    """Nor with a vehicle's doors nearer: `DoorPolicy.reach_m`, and 0.2 m to the open door."""
    guided_mps: PositiveFloat = 40 / 3.6
    """Of an overtaking that a passenger asked for. The design's."""
    creep_mps: PositiveFloat = 8 / 3.6
    """Walking pace. The design's: the quickest that still counts as one."""
    tolerance_mps: NonNegativeFloat = 1.0
    """So much over the plan's cap ends it: above what a speed controller overshoots by."""


class TrackingPolicy(Model):
    """How the vehicle drives a path from where it is and as it points. Read by `tracking` and `guard`."""

    error_m: NonNegativeFloat = 0.9
    """Further beside its path, a plan ends: half a car's width."""
    askew_rad: NonNegativeFloat = 0.1
    """Turned by less from where the body should point, it is on its way without driving off first."""
    beside_m: NonNegativeFloat = 0.05
    """Beside the path by less, it is on it: what localisation is good for."""
    drift_mps: NonNegativeFloat = 0.25
    """A fault draws the body aside no more quickly. Ours: 3 degrees off the path at 20 km/h. A plan is begun only with
    gaps that leave room for that until the vehicle stands; at walking pace the gaps of `ClearancePolicy` are enough."""
    kept_s: NonNegativeFloat = 1.0
    """A tracking error is kept for so long beyond a stop: whatever keeps it there may last."""
    worked_off_m: PositiveFloat = 6.0
    """And then worked off within so many metres: about two wheelbases."""
    settles_m: PositiveFloat = 20.0
    """An askew start is followed up for so long."""
    lock_m: PositiveFloat = 1.5
    """The wheels are turned from straight to their lock within so many metres: a second at creeping speed."""
    straightens_m: PositiveFloat = 3.0
    """Backing up, what a body is askew fades over so much way: about a wheelbase."""
    reach_m: PositiveFloat = 2.0
    """The centre comes back to the path over about so much travel. Ours."""
    approach_rad: NonNegativeFloat = 0.45
    """And towards it at no steeper angle. Ours."""


class StoppingPolicy(Model):
    """Stops that end a plan, or that let others by. Read by `aborts` and `ways_out`, `rests_mps` also by `checks`."""

    every_m: PositiveFloat = 3.0
    """Stops are tried so far apart: less than a car's length, so that no one fits between two of them."""
    lag_s: NonNegativeFloat = 0.3
    """From the order to brake until the brakes bite. Ours: a hydraulic brake, and a tick or two of the loop."""
    gives_way_s: NonNegativeFloat = 2.5
    """Way is given to those who would be met within so long after a stop. Ours: late, since many turn off before."""
    goes_on_s: NonNegativeFloat = 6.0
    """And given on until nobody would be met within so long: the gap that drivers accept to cross a road."""
    stands_s: NonNegativeFloat = 3.0
    """The stop is looked at for so long: until the next look finds the same."""
    past_end_m: NonNegativeFloat = 0.5
    """And so far beyond its end: one station of the path."""
    rests_mps: NonNegativeFloat = 0.3
    """Slower, the ego is at rest: setting off is then a choice, and a line ahead has been stopped at."""
    return_least_mps: PositiveFloat = 3.0
    """A way back into the lane is laid out for this speed at least, ..."""
    return_s: NonNegativeFloat = 2.0
    """... so many seconds long, a brisk change of lane, ..."""
    return_least_m: PositiveFloat = 4.0
    """... and at least so many metres, a car's length."""


class HarmPolicy(Model):
    """The way out with the least harm, after the commit point. Read by `ways_out`."""

    touch_m: NonNegativeFloat = 0.1
    """A gap below this counts as contact: what perception measures is not better."""
    gentler_mps: NonNegativeFloat = 1.0
    """A stop must lower the impact by more: less is not known, and who drives on is out of the way sooner."""


class HandBackPolicy(Model):
    """Whether the stack may drive on by itself from where a plan was given up. Read by `hand_back`."""

    askew_rad: NonNegativeFloat = 0.2
    """Turned by less, and ..."""
    aside_m: NonNegativeFloat = 0.4
    """... displaced by less, a vehicle is in its lane: what stands before it is before its driver."""
    kept_m: NonNegativeFloat = 0.1
    """Kept from what stands on the tightest way back: `HarmPolicy.touch_m`, since drivers keep more."""
    most_turn_rad: PositiveFloat = 1.3
    """A vehicle turned by more is taken to be turned by this: beyond, no arc leads along the road."""
    speed_mps: PositiveFloat = 2.0
    """Such a way is driven so slowly."""
