"""Where objects may be: along their lane, straight on, and braking; and the ego beside them."""

from __future__ import annotations

import numpy as np

from stucksolver.decision.rollout import Rollout
from stucksolver.guard.case import Case
from stucksolver.scene.boxes import separation
from stucksolver.scene.frenet import Array
from stucksolver.scene.view import View

BRAKING_MPS2 = 3.5
CROSSING_MPS = 0.3
"""A lateral speed above this is taken for real and carried on."""


def times(case: Case) -> Array:
    """The instants at which the plan is examined, seconds from now."""
    end = min(case.slow.duration_s, case.policy.horizon_s)
    result: Array = np.arange(0.0, end + case.policy.step_s, case.policy.step_s)
    return result


def relevant(case: Case) -> Array:
    """Indices of the objects that the plan can meet at all.

    Left out: same-direction traffic that comes from behind the ego (it answers for its own distance; the lane entry
    check covers lanes the ego moves into).
    """
    view, span = case.view, case.slow.duration_s
    rear = view.ego_s - view.ego.length_m / 2
    from_behind = (view.s + view.along < rear) & (view.vs > -0.5) & (np.abs(view.vd) < CROSSING_MPS * 2)
    move = np.abs(view.vs) * span + view.along + 5.0
    near_s = (view.s + move > case.path.s[0] - 5.0) & (view.s - move < case.path.end_s + 5.0)
    margin = view.across + np.abs(view.vd) * span + 2.0
    low, high = case.path.d.min() - case.reach.max(), case.path.d.max() + case.reach.max()
    near_d = (view.d + margin > low) & (view.d - margin < high)
    found: Array = np.flatnonzero(near_s & near_d & ~from_behind)
    return found


def predictions(view: View, which: Array, t: Array) -> tuple[Array, Array]:
    """(s, d) of objects under the hypotheses along-lane, straight, braking: arrays (3, times, objects)."""
    s, d, vs, vd = view.s[which], view.d[which], view.vs[which], view.vd[which]
    crossing = np.where(np.abs(vd) > CROSSING_MPS, vd, 0.0)
    until = np.minimum(t[:, None], np.abs(vs)[None, :] / BRAKING_MPS2)
    braked = s + np.sign(vs) * (np.abs(vs) * until - 0.5 * BRAKING_MPS2 * until**2)
    steady = s + vs * t[:, None]
    still = np.broadcast_to(d, steady.shape)
    return np.stack([steady, steady, braked]), np.stack([still, d + crossing * t[:, None], still])


def gaps(case: Case, run: Rollout, which: Array, t: Array) -> Array:
    """Separation from objects, least over the hypotheses: (times, objects), metres."""
    view = case.view
    station = run.station_at(t, case.path)
    offset = np.interp(station, case.path.s, case.path.d)
    heading = np.interp(station, case.path.s, case.heading)
    s, d = predictions(view, which, t)
    all_gaps = separation(
        (station[:, None], offset[:, None], heading[:, None]),
        (view.ego.length_m / 2, view.ego.width_m / 2),
        (s, d, view.yaw[which]),
        (view.half_length[which], view.half_width[which]),
    )
    least: Array = all_gaps.min(axis=0)
    return least
