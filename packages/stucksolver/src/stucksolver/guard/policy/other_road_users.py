"""What other road users are assumed to do: continue, brake, approach from behind, and come the other way."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.plan.speed_profile import SLUGGISH_ACCELERATION, SLUGGISH_SPEED
from stucksolver.scene.base_model import FrozenModel


class PredictionPolicy(FrozenModel):
    """Where others may be while a plan runs. Read by `predict`, `straight` and checks that tell directions apart."""

    horizon_s: PositiveFloat = 30.0
    """Nothing is predicted beyond this time. Ours: longer than any plan that does not creep all the way."""
    step_s: PositiveFloat = 0.2
    """Time between the instants checked: about 1 m at recovery speed, less than a body's length."""
    between_profiles_m: PositiveFloat = 2.5
    """Distance between two of the ego's speed profiles at one instant: half a car, so that no body fits between."""
    sluggish_speed: PositiveFloat = SLUGGISH_SPEED
    """The slow ego drives at this fraction of the speed that the plan allows."""
    sluggish_acceleration: PositiveFloat = SLUGGISH_ACCELERATION
    """The slow ego uses this fraction of its comfortable acceleration."""
    braking_mps2: PositiveFloat = 3.5
    """The strongest braking that others are assumed to choose: the 3.4 m/s² of AASHTO's stopping sight distance,
    rounded up. It bounds what they do; `RssPolicy.response_braking_mps2` bounds what they are able to do.
    """
    along_mps: NonNegativeFloat = 0.5
    """Above this speed along the road an object is traffic in that direction. Ours: above a tracker's noise."""
    steady_mps: NonNegativeFloat = 0.5
    """Below this lateral speed it counts as keeping its lane."""
    crossing_mps: NonNegativeFloat = 0.3
    """A lateral speed above this is real and is extrapolated. Ours: above the noise of a tracked heading."""
    overtaking_mps: NonNegativeFloat = 1.0
    """Whoever is faster than the ego by this much, and not past it yet, is overtaking."""
    sure_s: NonNegativeFloat = 1.0
    """Before a plan begins, traffic on other roads is assumed to be up to this much earlier than predicted."""
    sure_running_s: NonNegativeFloat = 0.3
    """The same while it runs. Smaller, so that a plan is not given up right after it begins."""
    sets_off_mps: NonNegativeFloat = 3.0
    """A vehicle on another road that is slower than this may be setting off. Ours: reached within two seconds of it."""
    sets_off_mps2: PositiveFloat = 2.0
    """It then accelerates by this much, as `EntryPolicy.accelerates_mps2`, ..."""
    crosses_mps: PositiveFloat = 30 / 3.6
    """... up to this speed. Ours: few are faster across a junction from rest."""
    turns_rad: NonNegativeFloat = 0.2
    """If the route turns by more than this in a junction, oncoming traffic does not follow it."""
    far_m: NonNegativeFloat = 2.0
    """More than any required gap: beyond this distance gaps are not computed."""
    reserve_along_m: NonNegativeFloat = 5.0
    """An object that stays further than this from the path along the road is skipped: a car's length."""
    reserve_across_m: NonNegativeFloat = 2.0
    """The same across the road: `far_m`."""
    reserve_in_plane_m: NonNegativeFloat = 10.0
    """The same for objects on other roads, which are predicted in the plane."""


class RssPolicy(FrozenModel):
    """Parameters of Responsibility-Sensitive Safety (Shalev-Shwartz, Shammah, Shashua 2017). Read by `rss`."""

    reaction_s: NonNegativeFloat = 1.0
    """rho of an attentive human driver."""
    response_braking_mps2: PositiveFloat = 3.5
    """b_min: the hardest braking that a plan may require of a driver behind; comfortable for most (3.4 m/s² in
    AASHTO's Green Book).
    """
    running_braking_mps2: PositiveFloat = 4.5
    """b_min once a plan runs: higher, so that the plan does not end when traffic from behind speeds up a little. Most
    drivers brake harder than this for an unexpected obstacle (the same book).
    """
    max_braking_mps2: PositiveFloat = 8.0
    """b_max: an emergency stop on a dry road."""
    lateral_braking_mps2: PositiveFloat = 1.0
    """b_min of the lateral distance (Lemma 4). Ours."""


class EntryPolicy(FrozenModel):
    """Traffic in the ego's direction where the path moves sideways. Read by `traffic` and `abreast`."""

    start_s: NonNegativeFloat = 0.3
    """From the command until the ego moves. Ours: the time a drivetrain takes to build up torque."""
    reserve_m: NonNegativeFloat = 1.0
    """Extra distance to others at the start, so that a plan is not given up right after it begins."""
    nose_rad: PositiveFloat = 0.1
    """A standing ego that is turned toward the lane beside by more than this, ..."""
    nose_m: NonNegativeFloat = 0.5
    """... with its nose this near to the border, is seen to want to enter. Ours: half a lane's room beside a car."""
    decides_s: NonNegativeFloat = 1.0
    """While a plan runs, an entry must be safe once it is no further ahead than a stop with this delay, ..."""
    decides_m: NonNegativeFloat = 3.0
    """... plus this distance. Ours: several ticks of a loop at 10 Hz, and a stop that ends short of the border."""
    stops_s: NonNegativeFloat = 0.5
    """The same if the nose is already in the lane: as late as a stop beside its traffic allows, ..."""
    stops_m: NonNegativeFloat = 0.5
    """... plus this distance: a station of the path."""
    next_look_s: NonNegativeFloat = 0.1
    """Until the next check: a tick of a loop at 10 Hz. An ego that has just set off gains speed until then."""
    beside_m: NonNegativeFloat = 0.3
    """Room that passing traffic needs beside the ego: the gap to stationary objects."""
    beside_people_m: NonNegativeFloat = 0.5
    """The same for pedestrians and cyclists who pass the ego: less than the ego keeps when it passes them."""
    accelerates_mps2: NonNegativeFloat = 2.0
    """Acceleration of traffic from behind, up to the limit, until it sees the ego in its lane: a brisk driver."""
    watching_reaction_s: NonNegativeFloat = 0.5
    """The reaction time of traffic that is watching the ego enter: half of rho."""
    own_reaction_s: NonNegativeFloat = 0.5
    """The ego's own rho behind traffic that it joins: two ticks of a loop at 10 Hz, and `StoppingPolicy.lag_s`."""
    in_line_m: NonNegativeFloat = 0.5
    """The ego is in line behind a vehicle within this lateral distance of its center. Ours: the slack within a lane."""
    headway_s: NonNegativeFloat = 0.5
    """Headway to traffic that the ego joins, besides the distance to brake to its speed. Ours: the stack follows it."""
    headway_m: NonNegativeFloat = 0.5
    """Distance added to that headway."""


class OncomingPolicy(FrozenModel):
    """The oncoming lane. Read by `oncoming` and `unseen`; the limit also by `sight` and `traffic`."""

    sight_margin_m: NonNegativeFloat = 10.0
    """Sight that must remain when the ego is back in its lane. AASHTO's passing sight distance includes such a
    clearance: 30 m and more for passes at 50 km/h and more. 10 m is ours, for passes at 20 km/h.
    """
    sight_margin_s: NonNegativeFloat = 0.75
    """Added to it: the distance driven in this time at the part of the speed above `SpeedPolicy.recovery_mps`. The
    clearance then lasts as long as 10 m do between 20 km/h and 30 km/h.
    """
    turning_mps2: PositiveFloat = 4.0
    """The highest lateral acceleration in a junction. AASHTO's Green Book designs turns at 15 to 25 km/h for side
    friction of 0.32 to 0.38 (3.7 m/s²); turning becomes uncomfortable at about 0.4 g. Rounded up.
    """
    least_crossing_rad: PositiveFloat = 1.05
    """The smallest angle at which roads are assumed to meet: 60 degrees, long the minimum for new intersections in
    the same book.
    """
    turned_accelerates_mps2: PositiveFloat = 3.0
    """The hardest acceleration of a vehicle after the turn: twice what is normal in traffic. Ours."""
    seen_ago_s: NonNegativeFloat = 0.5
    """Greatest age of the surroundings at the last check before the commit point: `GuardPolicy.max_age_s`."""
    time_gap_s: NonNegativeFloat = 1.5
    """Time between the ego's return and the arrival of oncoming traffic. Ours."""
    speedup_mps: NonNegativeFloat = 1.0
    """Oncoming traffic may be faster than seen by this much."""
    unknown_limit_mps: PositiveFloat = 50 / 3.6
    """Used if the map has no speed limit: the common limit in towns."""
