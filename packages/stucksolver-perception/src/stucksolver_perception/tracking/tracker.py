"""Tracks objects over time: association, Kalman filters, births and deaths, and since when they are stationary.

After Weng et al., "AB3DMOT: A Baseline for 3D Multi-Object Tracking and New Evaluation Metrics" (2020), with the
velocity-based association of Yin, Zhou and Krähenbühl, "Center-based 3D Object Detection and Tracking" (2021).
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stucksolver_perception.measurements import Detections, Floats, PoseEstimate
from stucksolver_perception.rig import Rig, load_rig
from stucksolver_perception.tracking import association, stationarity, track_management
from stucksolver_perception.tracking.motion_groups import GROUP_OF_LABEL, GROUPS, WHEELED
from stucksolver_perception.tracking.noise import NoisyDetections, measured
from stucksolver_perception.tracking.stationarity import Evidence, MotionState
from stucksolver_perception.tracking.track import Track
from stucksolver_perception.tracking.track_state import (
    NEW_VELOCITY_MPS,
    TrackState,
    may_move,
    new_track,
    predict,
    start_moving,
    stop_moving,
    update,
)

if TYPE_CHECKING:
    from stucksolver_perception.free_space import FreeSpace

CONFIRMING_HITS = 2
"""A track is reported after this many detections ..."""
CONFIRMING_SCORE = 0.99
"""... whose scores sum up to this, ..."""
SURE_SCORE = 0.7
"""... or after one detection with at least this score ..."""
SURE_RANGE_M = 20.0
"""... within this distance (m): near objects must not be reported late."""
HELD_MPS = 0.05
"""Below this speed the ego stands."""
BIRTH_SCORE = 0.2
"""Weaker detections keep tracks alive but start none."""


class ObjectTracker:
    """Call `update` with each look's detections, and `predict` whenever the objects are wanted."""

    def __init__(self, rig: Rig | None = None) -> None:
        """Make a tracker. `rig` says what the LiDAR can see; the one that ships with the package if None."""
        # The first import takes seconds: not in the first look.
        import filterpy.kalman  # type: ignore[import-untyped]  # noqa: F401
        import scipy.optimize  # type: ignore[import-untyped]  # noqa: F401

        self._lidar = (load_rig() if rig is None else rig).lidar
        self._bodies: list[TrackState] = []
        self._confirmed: set[int] = set()
        self._next = 1

    def update(
        self,
        detections: Detections,
        pose: PoseEstimate,
        space: FreeSpace | None = None,
        standing: Floats | None = None,
    ) -> tuple[Track, ...]:
        """Update the tracks with the detections of one look.

        Args:
            detections: Of a later look than before, in the vehicle frame.
            pose: The vehicle's pose at `detections.time_s`.
            space: What the LiDAR saw to be free at that look. Without it, nearer tracks decide who is hidden.
            standing: (m, 3): x, y, height above ground (m) of returns that stand up close ahead, in the vehicle frame.
                What stands and still returns them is still there, whatever the detector says.

        Returns:
            All confirmed tracks at `detections.time_s`, in the local frame, hidden ones included.
        """
        seen = measured(detections.part(association.suppress_duplicates(detections)), pose)
        for body in self._bodies:
            body.looked_s = body.time_s
            predict(body, seen.time_s, held=abs(pose.speed_mps) < HELD_MPS)
        kept = [body for body in self._bodies if body.id in self._confirmed and body.motion is MotionState.STANDING]
        before = track_management.tracks_explaining_returns(kept, pose, standing) if standing is not None else {}
        pairs = association.assign(self._bodies, seen)
        for i, j in pairs:
            update(self._bodies[i], seen, j)
            self._hit(self._bodies[i], seen, j)
        found = [self._bodies[i] for i, _ in pairs]
        taken = {j for _, j in pairs}
        met = {body.id for body in found}
        missed = [body for body in self._bodies if body.id not in met]
        if standing is not None:
            # The rear of a bus that has driven on is within the long box that it left behind.
            lost = [body for body in missed if body.id in before and WHEELED[body.label]]
            vehicles = [body for body in found if WHEELED[body.label]]
            others = standing[~track_management.explained_by(vehicles, pose, standing)]
            gone = {body.id for body in lost} - track_management.tracks_explaining_returns(lost, pose, others).keys()
            before = {name: odds for name, odds in before.items() if name not in gone}
        self._miss(missed, found, pose, space)
        for body in kept:
            body.odds = max(body.odds, before.get(body.id, body.odds))
        still = [body for body in missed if body.id in before]
        self._bear(seen, [j for j in range(len(seen)) if j not in taken], found, still)
        self._bodies = [b for b in self._bodies if not track_management.ended(b, seen.time_s, b.id in self._confirmed)]
        self._judge(seen.time_s)
        self._confirmed &= {body.id for body in self._bodies}
        return tuple(body.track() for body in self._bodies if body.id in self._confirmed)

    def predict(self, time_s: float) -> tuple[Track, ...]:
        """Return the confirmed tracks predicted to another time (s); the tracker does not change."""
        told = []
        for body in self._bodies:
            if body.id in self._confirmed:
                ahead = replace(body)
                predict(ahead, time_s)
                told.append(ahead.track())
        return tuple(told)

    def _hit(self, body: TrackState, seen: NoisyDetections, j: int) -> None:
        score = float(seen.score[j])
        track_management.hit(body, score)
        near = seen.range_m[j] < SURE_RANGE_M and score >= SURE_SCORE
        body.scores += score
        if (body.hits >= CONFIRMING_HITS and body.scores >= CONFIRMING_SCORE) or near:
            self._confirmed.add(body.id)

    def _miss(
        self, missed: list[TrackState], found: list[TrackState], pose: PoseEstimate, space: FreeSpace | None
    ) -> None:
        if not missed:
            return
        hidden, free = track_management.undetectable(missed, found, pose, self._lidar, space)
        for body, excused, seen_free in zip(missed, hidden.tolist(), free.tolist(), strict=True):
            x, y = float(body.x[0]), float(body.x[1])
            taken = association.inside_another(found, x, y) or association.near_same_class(found, body)
            away = math.hypot(body.x[0] - pose.x_m, body.x[1] - pose.y_m)
            if excused and not taken:
                body.hidden = True
                if abs(pose.speed_mps) < HELD_MPS:
                    track_management.keep_occluded(body, away, pose.time_s)
            else:
                track_management.miss(body, away, seen_free or taken)

    def _bear(self, seen: NoisyDetections, left: list[int], found: list[TrackState], still: list[TrackState]) -> None:
        """`still` was not detected, but is there: a thing in its box is a part of it. A person may be a person."""
        for j in left:
            lifeless, place = GROUPS[GROUP_OF_LABEL[seen.label[j]]].lifeless, seen.z[j, :2].tolist()
            others = [*found, *still] if lifeless else found
            if seen.score[j] < BIRTH_SCORE or association.inside_another(others, *place):
                continue
            if lifeless and association.in_track_wake(found, *place):
                continue
            body = new_track(self._next, seen, j)
            self._next += 1
            self._bodies.append(body)
            self._hit(body, seen, j)

    def _judge(self, now_s: float) -> None:
        """Decide for each object detected now whether it is stationary."""
        looked = [body for body in self._bodies if body.last_seen_s == now_s]
        if not looked:
            return
        evidence = stationarity.judge(np.array([body.samples for body in looked]), now_s)
        for i, body in enumerate(looked):
            _decide(body, evidence, i, now_s)


def _decide(body: TrackState, evidence: Evidence, i: int, now_s: float) -> None:
    """Advance one body's state of motion: moving until it rests, standing or undecided until it moves."""
    if body.motion is not MotionState.MOVING and evidence.moves[i] and may_move(body):
        if body.motion is MotionState.STANDING:
            body.x[4:] = evidence.velocity[i]
            body.p[4:, :] = body.p[:, 4:] = 0.0
            body.p[4:, 4:] = np.eye(2) * (evidence.variance[i] + NEW_VELOCITY_MPS**2)
        start_moving(body, now_s)
    elif body.motion is not MotionState.STANDING and (evidence.rests[i] or not may_move(body)):
        since = float(evidence.rests_since_s[i]) if evidence.rests[i] else now_s
        body.samples[body.samples[:, 0] < since - 1e-6] = -np.inf
        stop_moving(body, since)
        body.x[4:] = 0.0
    elif body.motion is MotionState.MOVING:
        body.moved_at_s = now_s
