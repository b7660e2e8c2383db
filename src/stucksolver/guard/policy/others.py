"""What others are assumed to do: continue, brake, come from behind, and come the other way."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.decision.rollout import SLUGGISH_ACCELERATION, SLUGGISH_SPEED
from stucksolver.scene.model import Model


class PredictionPolicy(Model):
    """Where others may be while a plan runs. Read by `predict`, `straight` and the checks of direction."""

    horizon_s: PositiveFloat = 30.0
    """Nothing is predicted beyond this time. Ours: longer than any plan that does not creep all the way."""
    step_s: PositiveFloat = 0.2
    """Time between the instants examined: 1 m at recovery speed, which the bodies' lengths cover."""
    between_profiles_m: PositiveFloat = 2.5
    """Distance between two of our speed profiles at one instant: half a car, so that no body passes between them."""
    sluggish_speed: PositiveFloat = SLUGGISH_SPEED
    """The slow ego drives this part of the speed that the plan allows."""
    sluggish_acceleration: PositiveFloat = SLUGGISH_ACCELERATION
    """The slow ego uses this part of its comfortable acceleration."""
    braking_mps2: PositiveFloat = 3.5
    """The strongest braking that others are assumed to choose: the 3.4 m/s² of AASHTO's stopping sight distance,
    rounded up. It bounds what they do; `RssPolicy.response_braking_mps2` bounds what they are able to do.
    """
    along_mps: NonNegativeFloat = 0.5
    """Above this speed along the road an object is traffic of that direction. Ours: above a tracker's noise."""
    steady_mps: NonNegativeFloat = 0.5
    """Up to this speed across the road it keeps its lane."""
    crossing_mps: NonNegativeFloat = 0.3
    """A lateral speed above this is real and is extrapolated. Ours: above the noise of a tracked heading."""
    overtaking_mps: NonNegativeFloat = 1.0
    """Someone faster than us by this, and not past us yet, is overtaking."""
    sure_s: NonNegativeFloat = 1.0
    """Traffic on another road may reach the crossing earlier than predicted by this time: before a plan begins."""
    sure_running_s: NonNegativeFloat = 0.3
    """The same while it runs: smaller, so that a plan is not given up at the next instant."""
    turns_rad: NonNegativeFloat = 0.2
    """If the route turns by more than this in a junction, oncoming traffic does not follow it."""
    far_m: NonNegativeFloat = 2.0
    """More than any lateral gap that is required: beyond it the exact value does not matter."""
    reserve_along_m: NonNegativeFloat = 5.0
    """An object that comes no nearer to the path along the road is skipped: a car's length."""
    reserve_across_m: NonNegativeFloat = 2.0
    """The same across the road: `far_m`."""
    reserve_in_plane_m: NonNegativeFloat = 10.0
    """The same for objects on other roads, which are predicted in the plane."""


class RssPolicy(Model):
    """Parameters of Responsibility-Sensitive Safety (Shalev-Shwartz, Shammah, Shashua 2017). Read by `rss`."""

    reaction_s: NonNegativeFloat = 1.0
    """rho of a human driver who looks ahead."""
    response_braking_mps2: PositiveFloat = 3.5
    """b_min: the strongest braking required of a driver behind us; comfortable for most (3.4 m/s² in AASHTO's
    Green Book).
    """
    running_braking_mps2: PositiveFloat = 4.5
    """b_min once a plan runs, so that the plan does not end when traffic from behind speeds up a little. Most
    drivers brake harder than this before something unexpected (the same book).
    """
    max_braking_mps2: PositiveFloat = 8.0
    """b_max: an emergency stop on a dry road."""
    lateral_braking_mps2: PositiveFloat = 1.0
    """b_min of the lateral distance (Lemma 4). Ours."""


class EntryPolicy(Model):
    """Others of our direction where the path moves sideways. Read by `traffic` and `abreast`."""

    start_s: NonNegativeFloat = 0.3
    """From the order to the first motion. Ours: until a drive train has taken up its torque."""
    reserve_m: NonNegativeFloat = 1.0
    """Extra distance to others at the start, so that a plan is not given up at the next instant."""
    decides_s: NonNegativeFloat = 1.0
    """While a plan runs, an entry must be certain once it is a stopping distance ahead, with this delay, ..."""
    decides_m: NonNegativeFloat = 3.0
    """... and this distance more. Ours: several ticks of a loop at 10 Hz, and a stop that ends short of the border."""
    stops_s: NonNegativeFloat = 0.5
    """The same if the nose is in the lane already: as late as a stop beside its traffic allows."""
    stops_m: NonNegativeFloat = 0.5
    """And this distance more: a station of the path."""
    beside_m: NonNegativeFloat = 0.3
    """Room that passing traffic needs beside us: the gap to standing objects."""
    beside_people_m: NonNegativeFloat = 0.5
    """The same for people and cyclists who pass by themselves: less than we keep when we pass them."""
    accelerates_mps2: NonNegativeFloat = 2.0
    """They may accelerate this much, up to the limit, until they see us in their lane: a brisk driver."""
    watching_reaction_s: NonNegativeFloat = 0.5
    """The reaction time of traffic that watches us enter: half of rho."""
    own_reaction_s: NonNegativeFloat = 0.5
    """Our own rho towards traffic that we enter behind: two ticks of a loop at 10 Hz, and `StoppingPolicy.lag_s`."""
    headway_s: NonNegativeFloat = 0.5
    """Kept from traffic that we enter behind, besides the braking distance to its speed. Ours: the stack follows."""
    headway_m: NonNegativeFloat = 0.5
    """And this distance more."""


class OncomingPolicy(Model):
    """The oncoming lane. Read by `oncoming` and `unseen`; the limit also by `sight` and `traffic`."""

    sight_margin_m: NonNegativeFloat = 10.0
    """Sight that must be left when the ego is back. AASHTO's passing sight distance has such a clearance of 30 m
    and more for passes at 50 km/h and more; 10 m is ours, for passes at 20 km/h.
    """
    sight_margin_s: NonNegativeFloat = 0.75
    """In addition, the way in this time at the speed above `SpeedPolicy.recovery_mps`. The clearance then lasts
    as long as 10 m do between 20 km/h and 30 km/h.
    """
    turning_mps2: PositiveFloat = 4.0
    """The highest lateral acceleration in a junction. AASHTO's Green Book designs turns at 15 to 25 km/h for side
    friction of 0.32 to 0.38 (3.7 m/s²); turning becomes uncomfortable at about 0.4 g. Rounded up.
    """
    least_crossing_rad: PositiveFloat = 1.05
    """Roads meet at no smaller angle than 60 degrees, the smallest that the same book long asked for at new
    intersections.
    """
    turned_accelerates_mps2: PositiveFloat = 3.0
    """After the turn a vehicle accelerates no harder than this: twice what is usual in traffic. Ours."""
    seen_ago_s: NonNegativeFloat = 0.5
    """Greatest age of the surroundings at the last look before the commit point: `GuardPolicy.max_age_s`."""
    time_gap_s: NonNegativeFloat = 1.5
    """Between the ego's return and oncoming traffic. Ours."""
    speedup_mps: NonNegativeFloat = 1.0
    """Oncoming traffic may be faster than seen by this much."""
    unknown_limit_mps: PositiveFloat = 50 / 3.6
    """Used if the map has no speed limit: the usual one in towns."""
