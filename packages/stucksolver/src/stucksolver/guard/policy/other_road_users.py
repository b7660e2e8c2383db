"""Assumptions about other road users: they continue, brake, approach from behind, or approach from the front."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.plan.speed_profile import SLUGGISH_ACCELERATION, SLUGGISH_SPEED
from stucksolver.scene.base_model import FrozenModel


class PredictionPolicy(FrozenModel):
    """Prediction of other road users while a plan runs. Read by `prediction`, `through_traffic` and other checks."""

    horizon_s: PositiveFloat = 30.0
    """Longest time that is predicted (s). Ours: longer than any plan that does not creep all the way."""
    step_s: PositiveFloat = 0.2
    """Time between the instants checked (s): about 1 m at recovery speed, less than a body's length."""
    between_profiles_m: PositiveFloat = 2.5
    """Distance between two of the ego's speed profiles at one instant (m): half a car, so that no body fits between."""
    sluggish_speed: PositiveFloat = SLUGGISH_SPEED
    """Speed of the slow ego, as a fraction of the speed that the plan allows."""
    sluggish_acceleration: PositiveFloat = SLUGGISH_ACCELERATION
    """Acceleration of the slow ego, as a fraction of its comfortable acceleration."""
    braking_mps2: PositiveFloat = 3.5
    """Hardest braking that others are assumed to choose (m/s²): the 3.4 m/s² of AASHTO's stopping sight distance,
    rounded up. It bounds their behavior; `RssPolicy.response_braking_mps2` bounds their ability.
    """
    along_mps: NonNegativeFloat = 0.5
    """Speed along the road above which an object is traffic in that direction (m/s). Ours: above a tracker's noise."""
    steady_mps: NonNegativeFloat = 0.5
    """Lateral speed below which an object counts as keeping its lane (m/s). Ours."""
    crossing_mps: NonNegativeFloat = 0.3
    """Lateral speed above which it is extrapolated (m/s). Ours: above the noise of a tracked heading."""
    overtaking_mps: NonNegativeFloat = 1.0
    """Excess over the ego's speed from which a vehicle counts as overtaking until it has passed (m/s). Ours."""
    sure_s: NonNegativeFloat = 1.0
    """Time by which traffic on other roads may be earlier than predicted, before a plan begins (s). Ours."""
    sure_running_s: NonNegativeFloat = 0.3
    """The same while a plan runs (s). It is smaller, so that a plan is not aborted right after it begins. Ours."""
    sets_off_mps: NonNegativeFloat = 3.0
    """Speed below which a vehicle on another road may be setting off (m/s). Ours: reached within two seconds of it."""
    sets_off_mps2: PositiveFloat = 2.0
    """Acceleration of a vehicle that sets off (m/s²): `EntryPolicy.accelerates_mps2`."""
    crosses_mps: PositiveFloat = 30 / 3.6
    """Final speed of a vehicle that sets off (m/s). Ours: few are faster across a junction from rest."""
    turns_rad: NonNegativeFloat = 0.2
    """Turn of the route in a junction above which oncoming traffic does not follow the route (rad). Ours."""
    far_m: NonNegativeFloat = 2.0
    """Distance beyond which gaps are not computed (m): more than any required gap."""
    reserve_along_m: NonNegativeFloat = 5.0
    """Distance from the path along the road beyond which an object is skipped (m): a car's length."""
    reserve_across_m: NonNegativeFloat = 2.0
    """Distance from the path across the road beyond which an object is skipped (m): `far_m`."""
    reserve_in_plane_m: NonNegativeFloat = 10.0
    """The same for objects on other roads, which are predicted in the plane (m). Ours."""


class RssPolicy(FrozenModel):
    """Parameters of Responsibility-Sensitive Safety (Shalev-Shwartz, Shammah, Shashua 2017). Read by `rss`."""

    reaction_s: NonNegativeFloat = 1.0
    """rho of an attentive human driver (s)."""
    response_braking_mps2: PositiveFloat = 3.5
    """b_min (m/s²): the hardest braking that a plan may require of a driver behind; comfortable for most (3.4 m/s² in
    AASHTO's Green Book).
    """
    running_braking_mps2: PositiveFloat = 4.5
    """b_min once a plan runs (m/s²): higher, so that the plan does not end when traffic from behind speeds up a little.
    Most drivers brake harder than this for an unexpected obstacle (the same book).
    """
    max_braking_mps2: PositiveFloat = 8.0
    """b_max (m/s²): an emergency stop on a dry road."""
    lateral_braking_mps2: PositiveFloat = 1.0
    """b_min of the lateral distance (m/s², Lemma 4). Ours."""


class EntryPolicy(FrozenModel):
    """Traffic in the ego's direction where the path moves sideways. Read by `lane_entry` and `adjacent_traffic`."""

    start_s: NonNegativeFloat = 0.3
    """Time from the command until the ego moves (s). Ours: the time a drivetrain takes to build up torque."""
    reserve_m: NonNegativeFloat = 1.0
    """Extra distance to others at the start (m), so that a plan is not aborted right after it begins. Ours."""
    nose_rad: PositiveFloat = 0.1
    """Least heading of a stopped ego toward the adjacent lane to signal its intent to enter (rad). Ours."""
    nose_m: NonNegativeFloat = 0.5
    """Greatest distance of its front corner to the lane border (m); both together signal the intent. Ours: half the
    space that a lane leaves beside a car.
    """
    decides_s: NonNegativeFloat = 1.0
    """Delay of the stop up to which a running plan may still cancel an entry (s). Ours: several ticks at 10 Hz."""
    decides_m: NonNegativeFloat = 3.0
    """Distance added to that stop (m): an entry within it must be safe now. Ours: a stop that ends short of the border.
    """
    stops_s: NonNegativeFloat = 0.5
    """The same delay if the front is already in the lane (s): as late as a stop beside its traffic allows."""
    stops_m: NonNegativeFloat = 0.5
    """The same distance if the front is already in the lane (m): a station of the path."""
    next_look_s: NonNegativeFloat = 0.1
    """Time until the next check (s): a tick of a loop at 10 Hz. An ego that has just set off gains speed until then."""
    beside_m: NonNegativeFloat = 0.3
    """Gap that passing traffic needs beside the ego (m): the gap to stationary objects."""
    beside_people_m: NonNegativeFloat = 0.5
    """The same for pedestrians and cyclists who pass the ego (m): less than the ego keeps when it passes them. Ours."""
    accelerates_mps2: NonNegativeFloat = 2.0
    """Acceleration of traffic from behind, up to the limit, until it detects the ego (m/s²): a brisk driver."""
    watching_reaction_s: NonNegativeFloat = 0.5
    """Reaction time of traffic that is watching the ego enter (s): half of rho."""
    own_reaction_s: NonNegativeFloat = 0.5
    """The ego's rho behind traffic that it joins (s): two ticks of a loop at 10 Hz, and `StoppingPolicy.lag_s`."""
    in_line_m: NonNegativeFloat = 0.5
    """Lateral distance within which the ego is in line behind a vehicle (m). Ours: the slack within a lane."""
    headway_s: NonNegativeFloat = 0.5
    """Headway to traffic that the ego joins, besides the distance to brake to its speed (s). Ours: the stack follows
    that traffic.
    """
    headway_m: NonNegativeFloat = 0.5
    """Distance added to that headway (m). Ours."""


class OncomingPolicy(FrozenModel):
    """Traffic in the oncoming lane. Read by `oncoming_lane`, `occluded_traffic`, `turn_around` and others."""

    sight_margin_m: NonNegativeFloat = 10.0
    """Sight distance that must remain when the ego is back in its lane (m). AASHTO's passing sight distance includes
    such a clearance: 30 m and more for passes at 50 km/h and more. 10 m is ours, for passes at 20 km/h.
    """
    sight_margin_s: NonNegativeFloat = 0.75
    """Time by which that margin grows with the speed above `SpeedPolicy.recovery_mps` (s). The clearance then lasts as
    long as 10 m do between 20 km/h and 30 km/h.
    """
    turning_mps2: PositiveFloat = 4.0
    """Highest lateral acceleration in a junction (m/s²). AASHTO's Green Book designs turns at 15 to 25 km/h for side
    friction of 0.32 to 0.38 (3.7 m/s²); turning becomes uncomfortable at about 0.4 g. Rounded up.
    """
    least_crossing_rad: PositiveFloat = 1.05
    """Smallest angle at which roads are assumed to cross (rad): 60 degrees, long the minimum for new intersections in
    the same book.
    """
    turned_accelerates_mps2: PositiveFloat = 3.0
    """Hardest acceleration of a vehicle after the turn (m/s²): twice what is normal in traffic. Ours."""
    seen_ago_s: NonNegativeFloat = 0.5
    """Greatest age of the surroundings at the last check before the commit point (s): `GuardPolicy.max_age_s`."""
    time_gap_s: NonNegativeFloat = 1.5
    """Time between the ego's return and the arrival of oncoming traffic (s). Ours."""
    speedup_mps: NonNegativeFloat = 1.0
    """Amount by which oncoming traffic may be faster than perceived (m/s). Ours."""
    unknown_limit_mps: PositiveFloat = 50 / 3.6
    """Speed limit if the map has none (m/s): the common limit in towns."""
