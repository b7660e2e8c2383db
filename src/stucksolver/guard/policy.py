"""The guard's numbers, in one place, and who must say yes to what."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from stucksolver.decision.behaviors import REGISTRY, Release
from stucksolver.decision.codes import WaitLimits
from stucksolver.scene.frenet import Array

RULES = ("solid_line", "emergency_scene", "school_bus", "level_crossing", "flagger", "red_light")
"""Besides the names of behaviours, what a person may be asked to release. A red light: an operator only."""


SCENES = ("emergency_scene", "school_bus", "level_crossing", "flagger")
RANKS = ("autonomous", "passenger", "operator", "forbid")
"""From the least to the most that may be asked for."""
PERSON_M, SLOW_MPS = 0.5, 1.5
"""Length of a person along the road; below that speed of ours a step off the kerb is answered by stopping."""


@dataclass(frozen=True)
class Approvals:
    """What people have said yes to for the plan at hand: names of behaviours, or of `RULES`."""

    passenger: frozenset[str] = frozenset()
    operator: frozenset[str] = frozenset()

    def cover(self, what: str, needed: Release) -> bool:
        """Is that enough for something that needs a yes of this rank? An operator's yes is also a passenger's."""
        if needed is Release.AUTONOMOUS or what in self.operator:
            return True
        return needed is Release.PASSENGER and what in self.passenger


NOBODY = Approvals()


@dataclass(frozen=True)
class GuardPolicy:
    """Bounds that no plan may cross. The defaults are the design's.

    `releases`: who must say yes to a behaviour, by its name; what is not named keeps the behaviour's own default.
    `solid_line`, `authority`: the same for crossing a solid line past a stationary obstruction (evaluation profiles
    set it to `autonomous`), and for passing a school bus, level crossing or flagger. `emergency_scene`: for passing a
    standing emergency vehicle otherwise than in a whole lane of our own direction.
    """

    releases: Mapping[str, Release] = field(default_factory=dict)
    solid_line: Literal["forbid", "autonomous", "passenger", "operator"] = "passenger"
    authority: Release = Release.OPERATOR
    emergency_scene: Release = Release.OPERATOR
    waits: WaitLimits = field(default_factory=WaitLimits)
    max_age_s: float = 0.5
    recovery_speed_mps: float = 20 / 3.6
    guided_speed_mps: float = 40 / 3.6
    creep_speed_mps: float = 8 / 3.6
    standing_gap_m: float = 0.3
    moving_gap_m: float = 0.5
    vulnerable_gap_m: float = 1.0
    door_m: float = 0.9
    """How far a door of a parked car reaches out."""
    step_mps: float = 1.4
    """How quickly a pedestrian may step off the kerb: a usual walking speed."""
    drivable_tolerance_m: float = 0.15
    sight_margin_m: float = 10.0
    oncoming_time_gap_s: float = 1.5
    oncoming_speedup_mps: float = 1.0
    unknown_oncoming_limit_mps: float = 50 / 3.6
    zone_margin_m: float = 3.0
    tracking_error_m: float = 0.9
    tracked_gap_m: float = 0.15
    """So much of each gap is left to tracking errors: while a plan runs it is examined from the ego's real pose."""
    solid_line_standing_s: float = 3.0
    off_route_m: float = 200.0
    off_route_s: float = 60.0
    passable_height_m: float = 0.15
    passable_size_m: float = 1.2
    """The longer side of what is driven over: a bin bag, an opened box."""
    passable_seen_s: float = 1.0
    passable_confidence: float = 0.8
    confirmed_confidence: float = 0.5
    """Enough where a passenger has confirmed what lies there."""
    living_clearance_m: float = 2.0
    horizon_s: float = 30.0
    step_s: float = 0.2
    reaction_s: float = 1.0
    response_braking_mps2: float = 3.5
    max_braking_mps2: float = 8.0
    """The last three are rho, b_min and b_max of the RSS distance."""
    running_braking_mps2: float = 4.5
    """b_min once a plan runs, which is not given up at once when who comes from behind speeds up a little."""
    lateral_braking_mps2: float = 1.0

    def __post_init__(self) -> None:
        unknown = sorted(set(self.releases) - set(REGISTRY))
        if unknown:
            raise ValueError(f"release of an unknown behaviour {unknown[0]!r}; there are: {', '.join(REGISTRY)}")

    def laxer_than(self, other: GuardPolicy) -> tuple[str, ...]:
        """What this policy lets be done with less of a yes than another one asks for."""
        asked: dict[str, tuple[str, str]] = {
            name: (self.release(name).value, other.release(name).value) for name in REGISTRY
        }
        asked |= {one: (self.scene_release(one).value, other.scene_release(one).value) for one in SCENES}
        asked["solid_line"] = (self.solid_line, other.solid_line)
        return tuple(name for name, (ours, theirs) in asked.items() if RANKS.index(ours) < RANKS.index(theirs))

    def scene_release(self, scene: str) -> Release:
        """Who must say yes to passing one of the scenes in `RULES`."""
        return self.emergency_scene if scene == "emergency_scene" else self.authority

    def release(self, behavior: str) -> Release:
        """Who must say yes to a behaviour."""
        return self.releases.get(behavior, REGISTRY[behavior].release)


def rss_distance(rear_mps: float, front_mps: float, policy: GuardPolicy, *, running: bool = False) -> float:
    """Longitudinal distance that a follower must keep, metres; `running`: while a plan runs.

    Lemma 2 of Shalev-Shwartz, Shammah and Shashua, "On a Formal Model of Safe and Scalable Self-driving Cars" (2017),
    with no acceleration during the reaction time: the rear vehicle has seen the other come.
    """
    braking = policy.running_braking_mps2 if running else policy.response_braking_mps2
    rear = rear_mps * policy.reaction_s + rear_mps**2 / (2 * braking)
    return max(rear - front_mps**2 / (2 * policy.max_braking_mps2), 0.0)


def rss_lateral(drift_mps: Array, mu_m: Array | float, policy: GuardPolicy) -> Array:
    """Lateral gap to keep from what drifts aside at a speed, metres.

    Lemma 4 of the same paper with a steady ego, whose own path is known: mu + v rho + v^2 / (2 b_lat).
    """
    result: Array = mu_m + drift_mps * policy.reaction_s + drift_mps**2 / (2 * policy.lateral_braking_mps2)
    return result


def step_off(speed_mps: Array, braking_mps2: float, policy: GuardPolicy) -> Array:
    """Lateral gap at which a pedestrian who steps off now cannot be met by our front, metres.

    Where we cannot stop before them, with half the reaction time of RSS (no human reacts) and the vehicle's hardest
    braking, we are nearer than rho/2 v + v^2 / (2 b), and going on we are past them within
    rho/2 + v / (2 b) + l / v seconds, l being their own length.
    """
    passing = PERSON_M / np.maximum(speed_mps, SLOW_MPS)
    result: Array = policy.step_mps * (policy.reaction_s / 2 + speed_mps / (2 * braking_mps2) + passing)
    return result
