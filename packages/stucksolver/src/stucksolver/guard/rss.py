"""Computes the distances of Responsibility-Sensitive Safety (RSS), and the gap to a pedestrian who may step off."""

from __future__ import annotations

import numpy as np

from stucksolver.guard.policy import PeoplePolicy, RssPolicy
from stucksolver.scene.frenet import Array


def rss_distance(rear_mps: float, front_mps: float, policy: RssPolicy, *, running: bool = False) -> float:
    """Return the longitudinal distance that a follower must keep (m). `running`: True if a plan is already running.

    Lemma 2 of Shalev-Shwartz, Shammah and Shashua, "On a Formal Model of Safe and Scalable Self-driving Cars" (2017).
    The reaction time has no acceleration here, because the rear driver has watched the other approach.
    """
    braking = policy.running_braking_mps2 if running else policy.response_braking_mps2
    rear = rear_mps * policy.reaction_s + rear_mps**2 / (2 * braking)
    return max(rear - front_mps**2 / (2 * policy.max_braking_mps2), 0.0)


def rss_lateral(drift_mps: Array, mu_m: Array | float, policy: RssPolicy) -> Array:
    """Return the lateral gap to keep from objects that drift sideways (m), in the shape of `drift_mps` and `mu_m`.

    Lemma 4 of the same paper for an ego that does not drift, since its path is known: mu + v rho + v^2 / (2 b_lat).
    """
    result: Array = mu_m + drift_mps * policy.reaction_s + drift_mps**2 / (2 * policy.lateral_braking_mps2)
    return result


def step_off(speed_mps: Array, braking_mps2: float, policy: PeoplePolicy) -> Array:
    """Return the lateral gap at which the ego's front cannot hit a pedestrian who steps off now, for each speed (m).

    An ego that cannot stop before the pedestrian is nearer than r v + v^2 / (2 b), with its reaction time r and its
    hardest braking b. If it continues, it has passed a pedestrian of length l within r + v / (2 b) + l / v seconds.
    """
    passing = policy.length_m / np.maximum(speed_mps, policy.stopping_below_mps)
    result: Array = policy.step_mps * (policy.reaction_s + speed_mps / (2 * braking_mps2) + passing)
    return result
