"""Gaps that the ego keeps to objects, vehicles, people and doors, and limits for driving over an object."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.scene.base_model import FrozenModel


class ClearancePolicy(FrozenModel):
    """Gaps between the ego's body and the boxes of others.

    Read by the checks along a path, by those of stops, of turns and of backing up, and by `hand_back`.
    """

    standing_gap_m: NonNegativeFloat = 0.3
    """Gap to stationary objects (m), and between two vehicles that creep. Ours: a 3.5 m lane leaves this gap beside a
    car parked at its edge.
    """
    moving_gap_m: NonNegativeFloat = 0.5
    """Gap to moving objects (m): the lateral margin mu of RSS (Lemma 4). Ours."""
    vulnerable_gap_m: NonNegativeFloat = 1.0
    """Gap to pedestrians and cyclists (m): about the three feet that many passing laws require beside a cyclist."""
    nearer_m: NonNegativeFloat = 0.05
    """Least decrease of a gap that is already below its bound for the object to count (m). Ours: a hand's breadth,
    above the noise of a constant gap.
    """
    parting_m: PositiveFloat = 0.5
    """Distance after which the path of an ego in contact with an object must have parted from it (m). Ours: enough to
    back straight off, too little to scrape along.
    """
    tracked_gap_m: NonNegativeFloat = 0.15
    """Part of each gap that tracking errors may use up while a plan runs (m). The running plan is checked from the
    real pose of the ego. Ours.
    """
    drifted_gap_m: NonNegativeFloat = 0.15
    """Gap that must remain after a tracking error and the drift until a stop (m); below it a plan is aborted. It
    detects an error that grows too slowly for `nearer_m`. Ours.
    """


class PeoplePolicy(FrozenModel):
    """Pedestrian at the curb who steps off. Read by `rss.step_off`."""

    step_mps: PositiveFloat = 1.4
    """Speed of the step (m/s): a normal walking speed."""
    length_m: PositiveFloat = 0.5
    """Length of the pedestrian along the road (m)."""
    stopping_below_mps: PositiveFloat = 1.5
    """Speed below which the ego responds by stopping (m/s). Ours: about walking speed, below which driving past takes
    longer than a stop.
    """
    reaction_s: NonNegativeFloat = 0.5
    """Time from the step until the ego brakes (s): half the reaction time of RSS, without a human driver."""


class DoorPolicy(FrozenModel):
    """Doors of parked vehicles. Read by `path_checks` and `speed_caps`."""

    reach_m: NonNegativeFloat = 0.9
    """Reach of an open door (m): a typical front door."""
    parked_s: NonNegativeFloat = 3.0
    """Time after which a stationary vehicle counts as parked, so that a door may open (s). Ours: as for hazard lights.
    """
    part_of_length: NonNegativeFloat = 0.5
    """Part of a vehicle's length, around its middle, in which the doors are. Ours."""


class PassablePolicy(FrozenModel):
    """Objects that may be driven over. Read by `passable_obstacles`; `height_m` also by `hand_back`."""

    height_m: NonNegativeFloat = 0.15
    """Largest height (m): about the ground clearance of a passenger car."""
    size_m: NonNegativeFloat = 1.2
    """Largest size of the longer side (m): a bin bag, a flattened box."""
    seen_s: NonNegativeFloat = 1.0
    """Least time for which the object must have been tracked (s): at least ten frames of a typical detector."""
    confidence: NonNegativeFloat = 0.8
    """Least confidence of the class. Ours."""
    confirmed_confidence: NonNegativeFloat = 0.5
    """Least confidence if a person has confirmed the object: more likely than not."""
    living_clearance_m: NonNegativeFloat = 2.0
    """Least distance to a living being or an unknown object (m): beyond the reach of a child for a toy. Ours."""
