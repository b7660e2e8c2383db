"""The distances of Responsibility-Sensitive Safety (RSS), and the one to somebody who steps off the kerb."""

from __future__ import annotations

import numpy as np

from stucksolver.guard.policy import PeoplePolicy, RssPolicy
from stucksolver.scene.frenet import Array


def rss_distance(rear_mps: float, front_mps: float, policy: RssPolicy, *, running: bool = False) -> float:
    """Longitudinal distance that a follower must keep, metres; `running`: while a plan runs.

    Lemma 2 of Shalev-Shwartz, Shammah and Shashua, "On a Formal Model of Safe and Scalable Self-driving Cars" (2017),
    with no acceleration during the reaction time: the rear vehicle has seen the other come.
    """
    braking = policy.running_braking_mps2 if running else policy.response_braking_mps2
    rear = rear_mps * policy.reaction_s + rear_mps**2 / (2 * braking)
    return max(rear - front_mps**2 / (2 * policy.max_braking_mps2), 0.0)


def rss_lateral(drift_mps: Array, mu_m: Array | float, policy: RssPolicy) -> Array:
    """Lateral gap to keep from what drifts aside at a speed, metres; of the shape of `drift_mps` and `mu_m`.

    Lemma 4 of the same paper with a steady ego, whose own path is known: mu + v rho + v^2 / (2 b_lat).
    """
    result: Array = mu_m + drift_mps * policy.reaction_s + drift_mps**2 / (2 * policy.lateral_braking_mps2)
    return result


def step_off(speed_mps: Array, braking_mps2: float, policy: PeoplePolicy) -> Array:
    """Lateral gap at which a pedestrian who steps off now cannot be met by our front, metres, for each speed.

    Where we cannot stop before them, with our reaction time and the vehicle's hardest braking, we are nearer than
    r v + v^2 / (2 b), and going on we are past them within r + v / (2 b) + l / v seconds, l being their own length.
    """
    passing = policy.length_m / np.maximum(speed_mps, policy.stopping_below_mps)
    result: Array = policy.step_mps * (policy.reaction_s + speed_mps / (2 * braking_mps2) + passing)
    return result
