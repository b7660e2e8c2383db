"""What others are taken to do: how they go on, brake, come from behind, and come the other way."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.decision.rollout import SLUGGISH_ACCELERATION, SLUGGISH_SPEED
from stucksolver.scene.model import Model


class PredictionPolicy(Model):
    """Where others may be while a plan runs. Read by `predict`, `straight` and whoever asks who goes which way."""

    horizon_s: PositiveFloat = 30.0
    """Nothing is foretold beyond. Ours: longer than any plan takes that is not creeping all the way."""
    step_s: PositiveFloat = 0.2
    """Between the instants that are examined: 1 m at recovery speed, within what the bodies' lengths cover."""
    between_profiles_m: PositiveFloat = 2.5
    """Between two speed profiles of ours at one instant: half a car, so that no body passes between two of them."""
    sluggish_speed: PositiveFloat = SLUGGISH_SPEED
    """The slow ego drives so much of the speed that the plan allows."""
    sluggish_acceleration: PositiveFloat = SLUGGISH_ACCELERATION
    """And accelerates with so much of its comfortable acceleration."""
    braking_mps2: PositiveFloat = 3.5
    """Others may brake with up to this: the 3.4 m/s² of AASHTO's stopping sight distance, rounded up. It bounds what
    they do, `RssPolicy.response_braking_mps2` what they are able to do."""
    along_mps: NonNegativeFloat = 0.5
    """Who goes along the road quicker than this is traffic of that direction. Ours: above a tracker's noise."""
    steady_mps: NonNegativeFloat = 0.5
    """Who goes across it no quicker keeps their lane."""
    crossing_mps: NonNegativeFloat = 0.3
    """A lateral speed above this is taken for real and carried on. Ours: above the noise of a tracked heading."""
    overtaking_mps: NonNegativeFloat = 1.0
    """Who is quicker than us by this, and not past us yet, is overtaking."""
    sure_s: NonNegativeFloat = 1.0
    """So much earlier than foretold may somebody on another road be where the ways meet: before a plan begins."""
    sure_running_s: NonNegativeFloat = 0.3
    """The same while it runs: less, that a plan begun be not given up in the next instant."""
    turns_rad: NonNegativeFloat = 0.2
    """A route that turns by more in a junction is not what those follow who come the other way."""
    far_m: NonNegativeFloat = 2.0
    """More than any gap that is asked for at the side: beyond it nobody need know how far exactly."""
    reserve_along_m: NonNegativeFloat = 5.0
    """Whoever comes no nearer to the path along it is left out unexamined: a car's length."""
    reserve_across_m: NonNegativeFloat = 2.0
    """The same across it: `far_m`."""
    reserve_in_plane_m: NonNegativeFloat = 10.0
    """The same for those on other roads, who are reckoned in the plane."""


class RssPolicy(Model):
    """Parameters of Responsibility-Sensitive Safety (Shalev-Shwartz, Shammah, Shashua 2017). Read by `rss`."""

    reaction_s: NonNegativeFloat = 1.0
    """rho, of a human driver who looks ahead."""
    response_braking_mps2: PositiveFloat = 3.5
    """b_min: what a driver behind us is asked for at most; comfortable for most (3.4 m/s² in AASHTO's Green Book)."""
    running_braking_mps2: PositiveFloat = 4.5
    """b_min once a plan runs, which is not given up at once when who comes from behind speeds up a little: what most
    drivers exceed before something unexpected (the same book)."""
    max_braking_mps2: PositiveFloat = 8.0
    """b_max: an emergency stop on a dry road."""
    lateral_braking_mps2: PositiveFloat = 1.0
    """b_min of the lateral distance (Lemma 4). Ours."""


class EntryPolicy(Model):
    """Others of our direction where the path moves sideways. Read by `traffic` and `abreast`."""

    start_s: NonNegativeFloat = 0.3
    """From the order to the first motion. Ours: until a drive train has taken up its torque."""
    reserve_m: NonNegativeFloat = 1.0
    """More distance to others at the start, so that a plan begun is not given up in the next instant."""
    decides_s: NonNegativeFloat = 1.0
    """While a plan runs, an entry must be certain when it is a way to stop, begun so much later, ..."""
    decides_m: NonNegativeFloat = 3.0
    """... and so much more ahead. Ours: several ticks of a loop at 10 Hz, and a stop that ends short of the border."""
    stops_s: NonNegativeFloat = 0.5
    """The same where the nose is in the lane already: as late as a stop beside those in it allows."""
    stops_m: NonNegativeFloat = 0.5
    """And so much more ahead: a station of the path."""
    beside_m: NonNegativeFloat = 0.3
    """Room beside us that those need who come by: the gap to what stands."""
    beside_people_m: NonNegativeFloat = 0.5
    """The same for people and cyclists, who come by of themselves: less than what we keep when we pass them."""
    accelerates_mps2: NonNegativeFloat = 2.0
    """So they may speed up, to the limit, until they see us in their lane: a brisk driver."""
    watching_reaction_s: NonNegativeFloat = 0.5
    """The reaction time of those who watch us come in: half of rho."""
    own_reaction_s: NonNegativeFloat = 0.5
    """Our own rho towards whom we come in behind: two ticks of a loop at 10 Hz, and `StoppingPolicy.lag_s`."""
    headway_s: NonNegativeFloat = 0.5
    """Kept, beside a way to brake down to their speed, from whom the path moves in behind. Ours: the stack follows."""
    headway_m: NonNegativeFloat = 0.5
    """And so much more."""


class OncomingPolicy(Model):
    """The oncoming lane. Read by `oncoming` and `unseen`; the limit also by `sight` and `traffic`."""

    sight_margin_m: NonNegativeFloat = 10.0
    """Left of the sight when the ego is back. AASHTO's passing sight distance has such a clearance between the two, of
    30 m and more, for passes at 50 km/h and more; 10 m is ours, for passes at 20 km/h."""
    sight_margin_s: NonNegativeFloat = 0.75
    """And the way of so many seconds of all speed above `SpeedPolicy.recovery_mps`: the clearance then lasts as long as
    10 m do between 20 km/h and 30 km/h."""
    turning_mps2: PositiveFloat = 4.0
    """Nobody turns in a junction with more lateral acceleration. AASHTO's Green Book designs turns at 15 to 25 km/h for
    side friction of 0.32 to 0.38 (3.7 m/s²); 0.4 g is about where turning becomes uncomfortable. Rounded up."""
    least_crossing_rad: PositiveFloat = 1.05
    """Roads meet at no smaller angle, 60 degrees: the least that the same book long asked of new intersections."""
    turned_accelerates_mps2: PositiveFloat = 3.0
    """And speeds up by no more once it has turned: twice what is usual in traffic. Ours."""
    seen_ago_s: NonNegativeFloat = 0.5
    """So old may what is seen be at the last look before the commit point: `GuardPolicy.max_age_s`."""
    time_gap_s: NonNegativeFloat = 1.5
    """Between the ego's return and who comes. Ours."""
    speedup_mps: NonNegativeFloat = 1.0
    """Who comes may be so much quicker than seen."""
    unknown_limit_mps: PositiveFloat = 50 / 3.6
    """Taken where the map has no speed limit: the usual one in towns."""
