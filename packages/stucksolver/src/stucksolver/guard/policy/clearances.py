"""How near the ego may come to objects, vehicles, people and doors, and what it may drive over."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.scene.base_model import FrozenModel


class ClearancePolicy(FrozenModel):
    """Gaps between the ego's body and the boxes of others. Read by `checks`, `aborts`, `ways_out` and `hand_back`."""

    standing_gap_m: NonNegativeFloat = 0.3
    """To stationary objects, and between two vehicles that creep. Ours: a 3.5 m lane leaves this much room beside a
    car parked at its edge.
    """
    moving_gap_m: NonNegativeFloat = 0.5
    """To moving objects: the lateral margin mu of RSS (Lemma 4). Ours."""
    vulnerable_gap_m: NonNegativeFloat = 1.0
    """To pedestrians and cyclists. About the three feet that many passing laws require beside a cyclist."""
    nearer_m: NonNegativeFloat = 0.05
    """An object already nearer than a bound counts only if the path comes nearer by this much. Ours: a hand's
    breadth, above the noise of a constant gap.
    """
    parting_m: PositiveFloat = 0.5
    """A path away from something that the ego stands against must have parted from it after this way. Ours: enough to
    back straight off, too little to scrape along.
    """
    tracked_gap_m: NonNegativeFloat = 0.15
    """Part of each gap that tracking errors may use up while a plan runs: the running plan is checked from the ego's
    real pose.
    """
    drifted_gap_m: NonNegativeFloat = 0.15
    """A plan ends if a tracking error, plus what a stop still adds to it, leaves less room than this. It catches an
    error that grows too slowly for `nearer_m`.
    """


class PeoplePolicy(FrozenModel):
    """A pedestrian who stands at the curb and steps off. Read by `rss.step_off`."""

    step_mps: PositiveFloat = 1.4
    """Speed of the step: a normal walking speed."""
    length_m: PositiveFloat = 0.5
    """Length of the pedestrian along the road."""
    stopping_below_mps: PositiveFloat = 1.5
    """Below this speed the ego responds by stopping. Ours: about walking speed, below which driving past would take
    longer than a stop.
    """
    reaction_s: NonNegativeFloat = 0.5
    """From the step until the ego brakes: half the reaction time of RSS, since no human driver has to react."""


class DoorPolicy(FrozenModel):
    """The doors of parked vehicles. Read by `checks`."""

    reach_m: NonNegativeFloat = 0.9
    """How far an open door reaches out: a typical front door."""
    parked_s: NonNegativeFloat = 3.0
    """Someone may be about to get out of a vehicle that has been stationary this long. Ours: as for hazard lights."""
    part_of_length: NonNegativeFloat = 0.5
    """Part of a vehicle's length, around its middle, in which the doors are."""


class PassablePolicy(FrozenModel):
    """What may be driven over. Read by `obstacles`."""

    height_m: NonNegativeFloat = 0.15
    """Largest height: about the ground clearance of a passenger car."""
    size_m: NonNegativeFloat = 1.2
    """Greatest length of the longer side: a bin bag, a flattened box."""
    seen_s: NonNegativeFloat = 1.0
    """Shortest time for which it must have been seen: at least ten frames of a typical detector."""
    confidence: NonNegativeFloat = 0.8
    """Smallest confidence of its class. Ours."""
    confirmed_confidence: NonNegativeFloat = 0.5
    """Confidence that is enough if a person has confirmed the object: more likely than not."""
    living_clearance_m: NonNegativeFloat = 2.0
    """Nothing living or unknown may be nearer to it than this: further than a child reaches for a toy. Ours."""
