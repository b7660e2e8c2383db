"""Checks passes through the oncoming lane: it must be visible and free from the commit point to the return.

Up to the commit point, a plan is checked again on every tick. A stop in the ego's own lane can end it (R17 and R19 in
docs/SAFETY.md). So occluded traffic is assumed to appear from the commit point on, not from the start. Traffic that
appears earlier is detected in time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stucksolver.guard.context import CheckContext
from stucksolver.guard.occluded_traffic import phantom_vehicles
from stucksolver.guard.verdict import RejectReason, SightDistanceProof
from stucksolver.scene.failed_attempts import RejectCode
from stucksolver.scene.frenet import Lane
from stucksolver.scene.road import LaneDirection
from stucksolver.scene.wording import whereabouts


@dataclass(frozen=True)
class LaneBorrow:
    """Use of an oncoming lane by a plan.

    Attributes:
        lane: Oncoming lane.
        first: Index of the first station at which the body is in the lane.
        last: Index of the first station at which the body is out of the lane again.
        decided_s: Time of the slow ego's last check before the commit point (s from now).
        back_s: Time at which the slow ego is out of the lane (s from now).
    """

    lane: Lane
    first: int
    last: int
    decided_s: float
    back_s: float

    @property
    def unseen_s(self) -> float:
        """Time from the last check before the commit point until the return (s); occluded traffic must not arrive."""
        return self.back_s - self.decided_s


def oncoming(case: CheckContext) -> list[RejectReason]:
    """Check that an oncoming lane is used only away from junctions and crossings, and free for the whole maneuver."""
    for borrowed in borrowed_lanes(case):
        rejects = _zone(case, borrowed) + _sight(case, borrowed) + _gap(case, borrowed)
        if rejects:
            return rejects
    return []


def borrowed_lanes(case: CheckContext) -> tuple[LaneBorrow, ...]:
    """Return the oncoming lanes that a plan uses, in order."""
    borrows = []
    for lane in case.path.enters:
        stations = np.flatnonzero(case.inside(lane))
        if lane.strip.direction is not LaneDirection.OPPOSITE or not len(stations):
            continue
        first, last = int(stations[0]), min(int(stations[-1]) + 1, len(case.path.s) - 1)
        borrows.append(LaneBorrow(lane, first, last, _decided_s(case, first), float(case.slow.t[last])))
    return tuple(borrows)


def _decided_s(case: CheckContext, first: int) -> float:
    """Return the time of the last check before the commit point (s from now); 0 if this check is the last."""
    if case.commit_s is None:
        return 0.0
    decision_s = min(case.commit_s, float(case.path.s[first]))
    reached_s = float(np.interp(decision_s, case.path.s, case.slow.t))
    return max(reached_s - case.policy.oncoming.seen_ago_s, 0.0)


def _zone(case: CheckContext, borrowed: LaneBorrow) -> list[RejectReason]:
    half = case.view.ego.length_m / 2
    start, end = float(case.path.s[borrowed.first]) - half, float(case.path.s[borrowed.last]) + half
    margin = case.policy.lanes.zone_margin_m
    for zone in case.view.surroundings.road.zones:
        if zone.start_m - margin < end and start < zone.end_m + margin:
            detail = f"oncoming lane used within {margin:.1f} m of a {zone.kind.value.replace('_', ' ')}"
            return [RejectReason(code=RejectCode.ZONE, detail=detail)]
    if not borrowed.lane.covers(start, end):
        return [RejectReason(code=RejectCode.OFF_ROAD, detail="the oncoming lane ends before the path does")]
    return []


def _sight(case: CheckContext, borrowed: LaneBorrow) -> list[RejectReason]:
    """Check the sight distance: at least the ego's path, plus the distance of occluded traffic, plus a margin."""
    proof = sight_proof(case, borrowed)
    needed, sight_m = proof.needed_m, proof.seen_m
    if sight_m >= needed:
        return []
    detail = f"oncoming lane: sight distance {sight_m:.1f} m, required {needed:.1f} m for {borrowed.unseen_s:.1f} s"
    return [
        RejectReason(
            code=RejectCode.ONCOMING_SIGHT,
            detail=detail,
            time_s=borrowed.unseen_s,
            gap_m=sight_m - needed,
            margin=sight_m - needed,
            unit="m",
            needed_m=needed,
            seen_m=sight_m,
        )
    ]


def proof_of(case: CheckContext) -> SightDistanceProof | None:
    """Return the proof with the least margin among a plan's oncoming lanes; None if the plan uses none."""
    proofs = [sight_proof(case, borrowed) for borrowed in borrowed_lanes(case)]
    return min(proofs, key=lambda proof: proof.seen_m - proof.needed_m, default=None)


def sight_proof(case: CheckContext, borrowed: LaneBorrow) -> SightDistanceProof:
    """Return the required and the available sight distance, for the phantom vehicle with the smallest margin."""
    own = float(case.path.s[borrowed.last]) - case.view.ego_s + margin_m(case)
    proofs = [
        SightDistanceProof(
            needed_m=own + vehicle.way_m(borrowed.unseen_s), seen_m=vehicle.at_m, unseen_s=borrowed.unseen_s
        )
        for vehicle in phantom_vehicles(case, borrowed.lane)
    ]
    return min(proofs, key=lambda proof: proof.seen_m - proof.needed_m)


def margin_m(case: CheckContext) -> float:
    """Return the sight distance that must remain at the return (m). It grows with the speed of the plan."""
    policy = case.policy.oncoming
    quicker = max(float(case.quick.v.max()) - case.policy.speeds.recovery_mps, 0.0)
    return policy.sight_margin_m + policy.sight_margin_s * quicker


def _gap(case: CheckContext, borrowed: LaneBorrow) -> list[RejectReason]:
    """Check that no oncoming vehicle arrives before the ego is back, plus a time gap.

    After the last check, the vehicle may be slightly faster than perceived. Until then its speed is measured again.
    """
    policy, view = case.policy.oncoming, case.view
    front = float(case.path.s[borrowed.last]) + view.ego.length_m / 2
    for i, obj in enumerate(view.objects):
        coming = -float(view.vs[i])
        if coming < case.policy.prediction.along_mps or not case.traffic[i]:
            continue
        if view.s[i] + view.along[i] < view.ego_s:
            continue
        right, _, left = borrowed.lane.at(float(view.s[i]))
        if view.d[i] + view.across[i] <= right or view.d[i] - view.across[i] >= left:
            continue
        driven_m = coming * (borrowed.back_s + policy.time_gap_s)
        driven_m += policy.speedup_mps * (borrowed.unseen_s + policy.time_gap_s)
        front_s = float(view.s[i] - view.along[i]) - driven_m
        if front_s < front:
            location = whereabouts(float(view.s[i] - view.ego_s))
            detail = (
                f"{obj.kind.value} {obj.id} {location}: approaches at {coming:.1f} m/s, {front - front_s:.1f} m too "
                f"near for a return after {borrowed.back_s:.1f} s"
            )
            return [
                RejectReason(
                    code=RejectCode.ONCOMING_GAP,
                    detail=detail,
                    object_id=obj.id,
                    time_s=borrowed.back_s,
                    gap_m=front_s - front,
                    margin=front_s - front,
                    unit="m",
                )
            ]
    return []
