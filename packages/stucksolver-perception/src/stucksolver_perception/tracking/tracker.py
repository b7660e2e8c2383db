"""Tracks objects over time: association, Kalman filters, start and end of tracks, and tests of motion.

It follows Weng et al., "AB3DMOT: A Baseline for 3D Multi-Object Tracking and New Evaluation Metrics" (2020), with the
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
from stucksolver_perception.tracking.noise import NoisyDetections, with_noise
from stucksolver_perception.tracking.stationarity import Evidence, MotionState
from stucksolver_perception.tracking.track import Track
from stucksolver_perception.tracking.track_state import (
    NEW_VELOCITY_SD_MPS,
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

CONFIRMED_HITS = 2
"""Minimum number of detections of a reported track. Ours."""
CONFIRMED_SCORE = 0.99
"""Minimum sum of the scores of these detections. Ours."""
CERTAIN_SCORE = 0.7
"""Minimum score with which one detection is enough. Ours."""
CERTAIN_RANGE_M = 20.0
"""Maximum distance at which one detection is enough (m), because near objects must not be reported late. Ours."""
STOPPED_MPS = 0.05
"""Speed below which the ego counts as stopped (m/s). Ours."""
MIN_NEW_SCORE = 0.2
"""Minimum score of a detection that starts a track; weaker ones only continue tracks. Ours."""


class ObjectTracker:
    """Tracker of all objects. Call `update` with each cycle's detections, and `predict` at any time."""

    def __init__(self, rig: Rig | None = None) -> None:
        """Create a tracker for the LiDAR of a rig. Without a rig, use the one that ships with the package."""
        # The first import takes seconds. It happens here so that it does not delay the first cycle.
        import filterpy.kalman  # type: ignore[import-untyped]  # noqa: F401
        import scipy.optimize  # type: ignore[import-untyped]  # noqa: F401

        self._lidar = (load_rig() if rig is None else rig).lidar
        self._states: list[TrackState] = []
        self._confirmed: set[int] = set()
        self._next_id = 1

    def update(
        self,
        detections: Detections,
        pose: PoseEstimate,
        space: FreeSpace | None = None,
        standing: Floats | None = None,
    ) -> tuple[Track, ...]:
        """Update the tracks with the detections of one cycle.

        Args:
            detections: Detections in the vehicle frame, later than those before.
            pose: The vehicle's pose at `detections.time_s`.
            space: Free space at that time. Without it, nearer tracks decide which tracks are hidden.
            standing: (m, 3): x, y, height above the ground (m) of returns above the ground close ahead, in the vehicle
                frame. A stationary object with such returns still exists, even without a detection.

        Returns:
            All confirmed tracks at `detections.time_s` in the local frame, including hidden ones.
        """
        noisy = with_noise(detections.part(association.suppress_duplicates(detections)), pose)
        for state in self._states:
            state.last_cycle_s = state.time_s
            predict(state, noisy.time_s, ego_is_stopped=abs(pose.speed_mps) < STOPPED_MPS)
        # The odds of these tracks are stored before misses change them.
        stationary = [
            state for state in self._states if state.id in self._confirmed and state.motion is MotionState.STANDING
        ]
        odds_by_id = (
            track_management.tracks_explaining_returns(stationary, pose, standing) if standing is not None else {}
        )
        pairs = association.assign(self._states, noisy)
        for i, j in pairs:
            update(self._states[i], noisy, j)
            self._add_hit(self._states[i], noisy, j)
        detected = [self._states[i] for i, _ in pairs]
        assigned = {j for _, j in pairs}
        detected_ids = {state.id for state in detected}
        missed = [state for state in self._states if state.id not in detected_ids]
        if standing is not None:
            # A bus that has driven on has its rear within the long box of its former track, so returns that a detected
            # vehicle explains do not count for the track.
            lost = [state for state in missed if state.id in odds_by_id and WHEELED[state.label]]
            vehicles = [state for state in detected if WHEELED[state.label]]
            unexplained = standing[~track_management.explained_by(vehicles, pose, standing)]
            explaining = track_management.tracks_explaining_returns(lost, pose, unexplained)
            left_ids = {state.id for state in lost} - explaining.keys()
            odds_by_id = {track_id: odds for track_id, odds in odds_by_id.items() if track_id not in left_ids}
        self._add_misses(missed, detected, pose, space)
        for state in stationary:
            state.odds = max(state.odds, odds_by_id.get(state.id, state.odds))
        existing = [state for state in missed if state.id in odds_by_id]
        self._start_tracks(noisy, [j for j in range(len(noisy)) if j not in assigned], detected, existing)
        self._states = [
            state
            for state in self._states
            if not track_management.is_ended(state, noisy.time_s, state.id in self._confirmed)
        ]
        self._update_motion(noisy.time_s)
        self._confirmed &= {state.id for state in self._states}
        return tuple(state.track() for state in self._states if state.id in self._confirmed)

    def predict(self, time_s: float) -> tuple[Track, ...]:
        """Return the confirmed tracks predicted to another time (s). The tracker does not change."""
        tracks = []
        for state in self._states:
            if state.id in self._confirmed:
                predicted = replace(state)
                predict(predicted, time_s)
                tracks.append(predicted.track())
        return tuple(tracks)

    def _add_hit(self, state: TrackState, detections: NoisyDetections, j: int) -> None:
        score = float(detections.score[j])
        track_management.add_hit(state, score)
        is_certain = detections.range_m[j] < CERTAIN_RANGE_M and score >= CERTAIN_SCORE
        state.scores += score
        if (state.hits >= CONFIRMED_HITS and state.scores >= CONFIRMED_SCORE) or is_certain:
            self._confirmed.add(state.id)

    def _add_misses(
        self, missed: list[TrackState], detected: list[TrackState], pose: PoseEstimate, space: FreeSpace | None
    ) -> None:
        if not missed:
            return
        hidden, free = track_management.undetectable(missed, detected, pose, self._lidar, space)
        for state, is_hidden, is_free in zip(missed, hidden.tolist(), free.tolist(), strict=True):
            x, y = float(state.x[0]), float(state.x[1])
            is_taken = association.is_inside_track(detected, x, y) or association.is_near_same_label(detected, state)
            distance_m = math.hypot(state.x[0] - pose.x_m, state.x[1] - pose.y_m)
            if is_hidden and not is_taken:
                state.hidden = True
                if abs(pose.speed_mps) < STOPPED_MPS:
                    track_management.keep_occluded(state, distance_m, pose.time_s)
            else:
                track_management.add_miss(state, distance_m, is_free or is_taken)

    def _start_tracks(
        self, detections: NoisyDetections, unassigned: list[int], detected: list[TrackState], existing: list[TrackState]
    ) -> None:
        """Start tracks for unassigned detections.

        The tracks `existing` were not detected, but have returns. A static object in one of their boxes is a part of
        them. A pedestrian there may be a real one.
        """
        for j in unassigned:
            is_static = GROUPS[GROUP_OF_LABEL[detections.label[j]]].is_static
            position = detections.z[j, :2].tolist()
            others = [*detected, *existing] if is_static else detected
            if detections.score[j] < MIN_NEW_SCORE or association.is_inside_track(others, *position):
                continue
            if is_static and association.is_in_track_wake(detected, *position):
                continue
            state = new_track(self._next_id, detections, j)
            self._next_id += 1
            self._states.append(state)
            self._add_hit(state, detections, j)

    def _update_motion(self, now_s: float) -> None:
        """Decide for each object with a detection in this cycle whether it is stationary."""
        detected = [state for state in self._states if state.last_seen_s == now_s]
        if not detected:
            return
        evidence = stationarity.motion_evidence(np.array([state.samples for state in detected]), now_s)
        for i, state in enumerate(detected):
            _update_motion_state(state, evidence, i, now_s)


def _update_motion_state(state: TrackState, evidence: Evidence, i: int, now_s: float) -> None:
    """Update the motion state of a track: moving until it rests, stationary or undecided until it moves."""
    if state.motion is not MotionState.MOVING and evidence.moves[i] and may_move(state):
        if state.motion is MotionState.STANDING:
            state.x[4:] = evidence.velocity[i]
            state.p[4:, :] = state.p[:, 4:] = 0.0
            state.p[4:, 4:] = np.eye(2) * (evidence.variance[i] + NEW_VELOCITY_SD_MPS**2)
        start_moving(state, now_s)
    elif state.motion is not MotionState.STANDING and (evidence.rests[i] or not may_move(state)):
        since = float(evidence.rests_since_s[i]) if evidence.rests[i] else now_s
        state.samples[state.samples[:, 0] < since - 1e-6] = -np.inf
        stop_moving(state, since)
        state.x[4:] = 0.0
    elif state.motion is MotionState.MOVING:
        state.moved_at_s = now_s
