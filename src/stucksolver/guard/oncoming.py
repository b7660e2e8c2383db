"""A pass through the oncoming lane: seen free, and free of those who come, from the commit point until we are back.

Up to its commit point a plan is looked at again on every tick, and a stop in the own lane ends it (R17, R19). So who
comes out of what is not seen is reckoned with from that point on, not from the start of the plan: whoever comes earlier
is in sight by then.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.unseen import who_may_come
from stucksolver.guard.verdict import Reject, SightProof
from stucksolver.scene.attempts import RejectCode
from stucksolver.scene.frenet import Lane
from stucksolver.scene.road import LaneDirection
from stucksolver.scene.wording import whereabouts


@dataclass(frozen=True)
class Borrowed:
    """The use that a plan makes of an oncoming lane.

    `first`, `last`: the stations from which and to which the body is in it. `decided_s`: when the slow ego has its last
    look before the commit point, seconds from now; `back_s`: when it is out of the lane.
    """

    lane: Lane
    first: int
    last: int
    decided_s: float
    back_s: float

    @property
    def unseen_s(self) -> float:
        """For how long nobody may come who is not in sight at the last look before the commit point (s)."""
        return self.back_s - self.decided_s


def oncoming(case: CheckContext) -> list[Reject]:
    """An oncoming lane is entered only when seen free for the whole manoeuvre, away from junctions and crossings."""
    for borrowed in borrowed_lanes(case):
        found = _zone(case, borrowed) + _sight(case, borrowed) + _gap(case, borrowed)
        if found:
            return found
    return []


def borrowed_lanes(case: CheckContext) -> tuple[Borrowed, ...]:
    """The oncoming lanes that a plan uses, in order."""
    found = []
    for lane in case.path.enters:
        stations = np.flatnonzero(case.inside(lane))
        if lane.strip.direction is not LaneDirection.OPPOSITE or not len(stations):
            continue
        first, last = int(stations[0]), min(int(stations[-1]) + 1, len(case.path.s) - 1)
        found.append(Borrowed(lane, first, last, _decided_s(case, first), float(case.slow.t[last])))
    return tuple(found)


def _decided_s(case: CheckContext, first: int) -> float:
    """When what is seen was looked at last before the commit point, seconds from now; 0 where that is now."""
    if case.commit_s is None:
        return 0.0
    at = min(case.commit_s, float(case.path.s[first]))
    reached_s = float(np.interp(at, case.path.s, case.slow.t))
    return max(reached_s - case.policy.oncoming.seen_ago_s, 0.0)


def _zone(case: CheckContext, borrowed: Borrowed) -> list[Reject]:
    half = case.view.ego.length_m / 2
    start, end = float(case.path.s[borrowed.first]) - half, float(case.path.s[borrowed.last]) + half
    margin = case.policy.lanes.zone_margin_m
    for zone in case.view.surroundings.road.zones:
        if zone.start_m - margin < end and start < zone.end_m + margin:
            detail = f"the plan would use the oncoming lane in a {zone.kind.value.replace('_', ' ')}"
            return [Reject(code=RejectCode.ZONE, detail=detail)]
    if not borrowed.lane.covers(start, end):
        return [Reject(code=RejectCode.OFF_ROAD, detail="the oncoming lane ends beside the manoeuvre")]
    return []


def _sight(case: CheckContext, borrowed: Borrowed) -> list[Reject]:
    """Seen free: sight >= own way + what somebody who is not seen covers meanwhile + margin."""
    proof = sight_proof(case, borrowed)
    needed, seen = proof.needed_m, proof.seen_m
    if seen >= needed:
        return []
    detail = f"sees {seen:.0f} m of the oncoming lane, needs {needed:.0f} m for {borrowed.unseen_s:.1f} s"
    return [
        Reject(
            code=RejectCode.ONCOMING_SIGHT,
            detail=detail,
            time_s=borrowed.unseen_s,
            gap_m=seen - needed,
            needed_m=needed,
            seen_m=seen,
        )
    ]


def proof_of(case: CheckContext) -> SightProof | None:
    """The tightest proof of a plan's passes through oncoming lanes; None for a plan that uses none."""
    proofs = [sight_proof(case, borrowed) for borrowed in borrowed_lanes(case)]
    return min(proofs, key=lambda proof: proof.seen_m - proof.needed_m, default=None)


def sight_proof(case: CheckContext, borrowed: Borrowed) -> SightProof:
    """What must be seen, and what is, for the one of those who may come that leaves the least."""
    own = float(case.path.s[borrowed.last]) - case.view.ego_s + margin_m(case)
    proofs = [
        SightProof(needed_m=own + one.way_m(borrowed.unseen_s), seen_m=one.at_m, unseen_s=borrowed.unseen_s)
        for one in who_may_come(case, borrowed.lane)
    ]
    return min(proofs, key=lambda proof: proof.seen_m - proof.needed_m)


def margin_m(case: CheckContext) -> float:
    """Left of the sight when the ego is back, metres: the more, the quicker the plan is."""
    policy = case.policy.oncoming
    quicker = max(float(case.quick.v.max()) - case.policy.speeds.recovery_mps, 0.0)
    return policy.sight_margin_m + policy.sight_margin_s * quicker


def _gap(case: CheckContext, borrowed: Borrowed) -> list[Reject]:
    """No oncoming vehicle, a little quicker than seen, is met before the ego is back and a time gap has passed.

    How quick it is, is measured again until the commit point: up to there it is taken to be as quick as seen.
    """
    policy, view = case.policy.oncoming, case.view
    front = float(case.path.s[borrowed.last]) + view.ego.length_m / 2
    for i, thing in enumerate(view.objects):
        coming = -float(view.vs[i])
        if coming < case.policy.prediction.along_mps or view.s[i] + view.along[i] < view.ego_s:
            continue
        right, _, left = borrowed.lane.at(float(view.s[i]))
        if view.d[i] + view.across[i] <= right or view.d[i] - view.across[i] >= left:
            continue
        way = coming * (borrowed.back_s + policy.time_gap_s)
        way += policy.speedup_mps * (borrowed.unseen_s + policy.time_gap_s)
        place = float(view.s[i] - view.along[i]) - way
        if place < front:
            detail = (
                f"{thing.kind.value} {thing.id} comes at {coming:.1f} m/s, {whereabouts(float(view.s[i] - view.ego_s))}"
            )
            return [
                Reject(
                    code=RejectCode.ONCOMING_GAP,
                    detail=detail,
                    object_id=thing.id,
                    time_s=borrowed.back_s,
                    gap_m=place - front,
                )
            ]
    return []
