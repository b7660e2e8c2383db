"""How near the ego may come to what is there: to things and vehicles, people, doors, and what is driven over."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.scene.model import Model


class ClearancePolicy(Model):
    """Gaps between the ego's body and others' boxes. Read by `checks`, `aborts`, `ways_out` and `hand_back`."""

    standing_gap_m: NonNegativeFloat = 0.3
    """To what stands, and between two that creep. Ours: a lane of 3.5 m leaves it beside a car parked at its edge."""
    moving_gap_m: NonNegativeFloat = 0.5
    """The lateral margin mu of RSS (Lemma 4), to what moves. Ours."""
    vulnerable_gap_m: NonNegativeFloat = 1.0
    """To people on foot and cyclists. About the three feet that many passing laws ask for beside a cyclist."""
    nearer_m: NonNegativeFloat = 0.05
    """What is nearer than a bound already counts only when the way leads nearer still by this. Ours: a hand's breadth,
    above the noise of a gap that stays as it is."""
    tracked_gap_m: NonNegativeFloat = 0.15
    """So much of each gap is left to tracking errors while a plan runs, which is examined from the ego's real pose."""
    drifted_gap_m: NonNegativeFloat = 0.15
    """Nearer than this by a tracking error, and by what a stop still adds to it, a plan ends: errors that grow slowly
    leave each next step a little less."""


class PeoplePolicy(Model):
    """One who stands at the kerb and steps off. Read by `rss.step_off`."""

    step_mps: PositiveFloat = 1.4
    """How quickly they step off: a usual walking speed."""
    length_m: PositiveFloat = 0.5
    """Their length along the road."""
    stopping_below_mps: PositiveFloat = 1.5
    """Slower than this, we answer by stopping. Ours: about walking speed; going on would take longer than a stop."""
    reaction_s: NonNegativeFloat = 0.5
    """From the step to our brakes: half the reaction time of RSS, since no human reacts."""


class DoorPolicy(Model):
    """The doors of parked vehicles. Read by `checks`."""

    reach_m: NonNegativeFloat = 0.9
    """How far an open door reaches out: a usual front door."""
    parked_s: NonNegativeFloat = 3.0
    """A vehicle that has stood for so long may have somebody about to get out. Ours: as long as hazard lights count."""
    part_of_length: NonNegativeFloat = 0.5
    """Doors are on the middle half of a vehicle's length."""


class PassablePolicy(Model):
    """What is soft enough to be driven over. Read by `obstacles`."""

    height_m: NonNegativeFloat = 0.15
    """At most so high: about the ground clearance of a passenger car."""
    size_m: NonNegativeFloat = 1.2
    """The longer side of what is driven over: a bin bag, an opened box."""
    seen_s: NonNegativeFloat = 1.0
    """Seen for at least so long: ten frames or more of a usual detector."""
    confidence: NonNegativeFloat = 0.8
    """Of its class. Ours."""
    confirmed_confidence: NonNegativeFloat = 0.5
    """Enough where a passenger has confirmed what lies there: more likely than not."""
    living_clearance_m: NonNegativeFloat = 2.0
    """Nothing living, and nothing unknown, so near to it: a child reaches no further for its toy. Ours."""
