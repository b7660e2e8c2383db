"""How near the ego may come to objects: things, vehicles, people, doors, and what is driven over."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.scene.model import Model


class ClearancePolicy(Model):
    """Gaps between the ego's body and the boxes of others. Read by `checks`, `aborts`, `ways_out` and `hand_back`."""

    standing_gap_m: NonNegativeFloat = 0.3
    """To standing objects, and between two that creep. Ours: a 3.5 m lane leaves it beside a car parked at its edge."""
    moving_gap_m: NonNegativeFloat = 0.5
    """To moving objects: the lateral margin mu of RSS (Lemma 4). Ours."""
    vulnerable_gap_m: NonNegativeFloat = 1.0
    """To pedestrians and cyclists. About the three feet that many passing laws require beside a cyclist."""
    nearer_m: NonNegativeFloat = 0.05
    """An object already nearer than a bound counts only if the path comes nearer by this much. Ours: a hand's
    breadth, above the noise of a constant gap.
    """
    tracked_gap_m: NonNegativeFloat = 0.15
    """This part of each gap is reserved for tracking errors while a plan runs, which is checked from the ego's
    real pose.
    """
    drifted_gap_m: NonNegativeFloat = 0.15
    """A plan ends if a tracking error, with what a stop still adds to it, leaves less than this: a slowly growing
    error takes a little at each step.
    """


class PeoplePolicy(Model):
    """A pedestrian who stands at the kerb and steps off. Read by `rss.step_off`."""

    step_mps: PositiveFloat = 1.4
    """Speed of the step: a usual walking speed."""
    length_m: PositiveFloat = 0.5
    """Length of the pedestrian along the road."""
    stopping_below_mps: PositiveFloat = 1.5
    """Below this speed the ego responds by stopping. Ours: about walking speed; going on would take longer than a
    stop.
    """
    reaction_s: NonNegativeFloat = 0.5
    """From the step to our brakes: half the reaction time of RSS, since no human reacts."""


class DoorPolicy(Model):
    """The doors of parked vehicles. Read by `checks`."""

    reach_m: NonNegativeFloat = 0.9
    """How far an open door reaches out: a usual front door."""
    parked_s: NonNegativeFloat = 3.0
    """A vehicle that has stood this long may have someone about to get out. Ours: as long as hazard lights count."""
    part_of_length: NonNegativeFloat = 0.5
    """Doors are on the middle half of a vehicle's length."""


class PassablePolicy(Model):
    """What is soft enough to be driven over. Read by `obstacles`."""

    height_m: NonNegativeFloat = 0.15
    """Largest height: about the ground clearance of a passenger car."""
    size_m: NonNegativeFloat = 1.2
    """Largest length of the longer side: a bin bag, an opened box."""
    seen_s: NonNegativeFloat = 1.0
    """Shortest time it must be seen: ten frames or more of a usual detector."""
    confidence: NonNegativeFloat = 0.8
    """Smallest confidence of its class. Ours."""
    confirmed_confidence: NonNegativeFloat = 0.5
    """Enough if a passenger has confirmed the object: more likely than not."""
    living_clearance_m: NonNegativeFloat = 2.0
    """Nothing living or unknown may be this near to it: a child does not reach further for a toy. Ours."""
