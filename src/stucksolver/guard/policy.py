"""The guard's numbers, in one place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class GuardPolicy:
    """Bounds that no plan may cross. The defaults are the design's.

    `solid_line`: `forbid`, or `autonomous` as evaluation profiles set it; crossing one is then allowed past a
    stationary obstruction only.
    """

    solid_line: Literal["forbid", "autonomous"] = "forbid"
    max_age_s: float = 0.5
    recovery_speed_mps: float = 20 / 3.6
    guided_speed_mps: float = 40 / 3.6
    standing_gap_m: float = 0.3
    moving_gap_m: float = 0.5
    vulnerable_gap_m: float = 1.0
    drivable_tolerance_m: float = 0.15
    sight_margin_m: float = 10.0
    oncoming_time_gap_s: float = 1.5
    oncoming_speedup_mps: float = 1.0
    unknown_oncoming_limit_mps: float = 50 / 3.6
    zone_margin_m: float = 3.0
    tracking_error_m: float = 0.9
    solid_line_standing_s: float = 3.0
    queue_moved_within_s: float = 60.0
    horizon_s: float = 30.0
    step_s: float = 0.2
    reaction_s: float = 1.0
    response_braking_mps2: float = 3.5
    max_braking_mps2: float = 8.0
    """The last three are rho, b_min and b_max of the RSS distance."""


def rss_distance(rear_mps: float, front_mps: float, policy: GuardPolicy) -> float:
    """Longitudinal distance that a follower must keep, metres.

    Lemma 2 of Shalev-Shwartz, Shammah and Shashua, "On a Formal Model of Safe and Scalable Self-driving Cars" (2017),
    with no acceleration during the reaction time: the rear vehicle has seen the other come.
    """
    rear = rear_mps * policy.reaction_s + rear_mps**2 / (2 * policy.response_braking_mps2)
    return max(rear - front_mps**2 / (2 * policy.max_braking_mps2), 0.0)
