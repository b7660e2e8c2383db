"""Maintains the tracker's state of one object: Kalman filter, votes, last detections."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Floats
from stucksolver_perception.tracking.motion_groups import GROUP_OF_LABEL, GROUPS, WHEELED, MotionGroup
from stucksolver_perception.tracking.motion_prediction import STATE, transition
from stucksolver_perception.tracking.noise import VELOCITY_CORRELATED, YAW_CORRELATED, NoisyDetections
from stucksolver_perception.tracking.stationarity import ALARM, SAMPLES, MotionState
from stucksolver_perception.tracking.track import TRACK_STATE, Track

STATIONARY_SD_MPS = 0.03
"""Standard deviation of a stationary object's velocity, in a zero-velocity update instead of the measurement (m/s).
Ours."""
NEW_VELOCITY_SD_MPS = 0.5
"""Additional standard deviation of a new or changing velocity (m/s). Ours."""
VOTES_PRIOR = 0.5
"""Weight added to the sum of votes, so that a few votes give no certainty. Ours."""
VOTES_DECAY = 0.98
"""Factor of a vote's weight per detection; at 10 Hz the weight halves in 3.4 s. Ours."""
SIZE_GAIN = 0.05
"""Gain of the size's running mean; the first 20 detections give their mean. Ours."""
COURSE_MPS = 1.5
"""Speed above which the course shows which end is the front (m/s). Ours."""
COURSE_VOTE = 3.0
"""Weight of the course in the votes for a heading. Ours."""
SLIP_SD_MPS = 0.3
"""Standard deviation of the velocity of a moving vehicle's center across its axis (m/s). In turns it is the yaw rate
times the distance to the rear axle. Ours."""
AXIS_HITS = 10
"""Number of first detections whose boxes show the axis poorly: that of a fast vehicle is rotated, by up to 90 degrees
for a truck at 60 km/h. If the velocity were forced into that axis, every few detections would start another track."""
COURSE_SD_RAD = 0.25
"""Standard deviation of the course below which the axis of a new vehicle is its course (rad). Ours."""
MIN_COURSE_MPS = 3.0
"""Speed above which no vehicle drives in reverse (m/s). Ours."""
MAX_HEADING_VOTES = 10.0
"""Maximum sum of the votes for a heading, so that an error can be corrected. Ours."""
MAX_ODDS = 5.0
"""Maximum log odds of existence: 99.3 %. Ours."""
GAP_S = 0.5
"""Time without a detection after which a stationary object is compared with its earlier position (s). Ours."""
GAP_SHIFT_M = 0.3
"""Standard deviation of the measured center's shift after such a gap, because other sides are visible (m). Ours."""
PEDESTRIAN = LABELS.index("pedestrian")
"""Index of the label."""
RETURN_M, RETURN_S = 0.5, 10.0
"""Distance (m) from its earlier position, and time (s), within which an object that stops again has not moved, because
boxes drift while the ego turns or backs up. Ours."""
SHIFTED_M, STEP_M = 0.5, 0.15
"""Minimum shift of a moving static object over its last detections (m), and minimum share of the shift in each half of
them. A confusion with a neighboring object, or with a part of a passing car, is a jump in one of the halves. Ours."""
MEDIAN_HITS = 3
"""Number of detections whose median is one position; three positions are compared. Ours."""


@dataclass(frozen=True)
class StandingSpell:
    """A time during which an object was stationary, before it seemed to move."""

    x_m: float
    y_m: float
    since_s: float
    """Start of the time (s)."""
    moved_at_s: float | None
    """Time at which the object last moved before (s); None if it never did."""
    left_s: float
    """Time at which the object seemed to move (s)."""


@dataclass(eq=False)
class TrackState:
    """State of one object. Only the tracker changes it; `track` returns the present values."""

    id: int
    x: Floats
    """(6,): x, y, z, yaw, vx, vy."""
    p: Floats
    """(6, 6): covariance of `x`."""
    size: Floats
    """(3,): length, width, height (m)."""
    time_s: float
    first_seen_s: float
    last_seen_s: float
    hits: int = 0
    """Number of detections."""
    heights: int = 0
    """Number of detections with a measured height."""
    odds: float = 0.0
    """Log odds that the object exists."""
    scores: float = 0.0
    """Sum of the scores of all detections."""
    strength: float = 0.0
    """Running mean of the scores of the last cycles; a miss counts as 0."""
    hidden: bool = False
    last_cycle_s: float = 0.0
    """Time of the previous cycle (s)."""
    concealed_s: float = 0.0
    """Time for which the stopped ego has hidden the object since the last detection (s)."""
    motion: MotionState = MotionState.UNDECIDED
    standing_since_s: float | None = None
    moved_at_s: float | None = None
    standing_spell: StandingSpell | None = None
    """The stationary time before the object seemed to move; None without one."""
    heading_votes: float = 0.0
    """Votes for the yaw; below 0 the opposite direction is the front."""
    votes: Floats = field(default_factory=lambda: np.zeros(len(LABELS)))
    """(labels,): votes for each label."""
    samples: Floats = field(default_factory=lambda: np.full((SAMPLES, 7), -np.inf))
    """(SAMPLES, 7): the last detections; see `stationarity.motion_evidence`."""

    @property
    def label(self) -> int:
        """The label with the most votes."""
        return int(self.votes.argmax())

    @property
    def group(self) -> MotionGroup:
        """The motion group of the label."""
        return GROUPS[GROUP_OF_LABEL[self.label]]

    @property
    def confidence(self) -> float:
        """Probability that the object exists."""
        return 1.0 / (1.0 + math.exp(-self.odds))

    def track(self) -> Track:
        """Return the present values."""
        is_stationary = self.motion is MotionState.STANDING
        label = self.label
        return Track(
            id=self.id,
            time_s=self.time_s,
            label=label,
            label_confidence=float(self.votes[label] / (self.votes.sum() + VOTES_PRIOR)),
            confidence=self.confidence,
            x_m=float(self.x[0]),
            y_m=float(self.x[1]),
            z_m=float(self.x[2]),
            yaw_rad=wrap_angle(float(self.x[3])),
            vx_mps=0.0 if is_stationary else float(self.x[4]),
            vy_mps=0.0 if is_stationary else float(self.x[5]),
            length_m=float(self.size[0]),
            width_m=float(self.size[1]),
            height_m=float(self.size[2]),
            covariance=self.p[np.ix_(TRACK_STATE, TRACK_STATE)],
            first_seen_s=self.first_seen_s,
            last_seen_s=self.last_seen_s,
            hits=self.hits,
            hidden=self.hidden,
            standing_since_s=self.standing_since_s,
            moved_at_s=self.moved_at_s,
        )


def new_track(number: int, detections: NoisyDetections, i: int) -> TrackState:
    """Return the state of an object from its first detection."""
    p = detections.noise[i].copy()
    p[4:, 4:] += np.eye(2) * NEW_VELOCITY_SD_MPS**2
    state = TrackState(
        number,
        detections.z[i].copy(),
        p,
        detections.size[i].copy(),
        detections.time_s,
        detections.time_s,
        detections.time_s,
    )
    _add_sample(state, detections, i)
    state.heights = int(detections.height_known[i])
    if state.group.is_static:
        state.motion, state.standing_since_s, state.x[4:] = MotionState.STANDING, detections.time_s, 0.0
    return state


def may_move(state: TrackState) -> bool:
    """Return False for a static object whose position has not shifted steadily."""
    if not state.group.is_static:
        return True
    positions = state.samples[np.isfinite(state.samples[:, 0]), 1:3][-3 * MEDIAN_HITS :]
    if len(positions) < 3 * MEDIAN_HITS:
        return False
    first, middle, last = (np.median(part, axis=0) for part in np.split(positions, 3))
    shift = last - first
    shift_m = float(np.hypot(*shift))
    halves = (middle - first, last - middle)
    return shift_m > SHIFTED_M and all(float(half @ shift) > STEP_M * shift_m for half in halves)


def start_moving(state: TrackState, now_s: float) -> None:
    """Set a track to moving, and store where it was stationary."""
    if state.standing_spell is not None and now_s - state.standing_spell.left_s > RETURN_S:
        state.standing_spell = None
    if state.standing_spell is None and state.standing_since_s is not None:
        state.standing_spell = StandingSpell(
            float(state.x[0]), float(state.x[1]), state.standing_since_s, state.moved_at_s, now_s
        )
    state.motion, state.standing_since_s, state.moved_at_s = MotionState.MOVING, None, now_s


def stop_moving(state: TrackState, since_s: float) -> None:
    """Set a track to stationary since a time (s). At its earlier position, it has been stationary all the time."""
    state.motion, state.standing_since_s = MotionState.STANDING, since_s
    spell = state.standing_spell
    is_back = spell is not None and math.hypot(state.x[0] - spell.x_m, state.x[1] - spell.y_m) < RETURN_M
    if spell is not None and is_back and state.time_s - spell.left_s < RETURN_S:
        state.standing_since_s, state.moved_at_s = spell.since_s, spell.moved_at_s
    elif state.moved_at_s is not None:
        state.moved_at_s = min(state.moved_at_s, since_s)


def predict(state: TrackState, time_s: float, ego_is_stopped: bool = False) -> None:
    """Predict a track to a time (s). While the ego is stopped, its pose does not drift."""
    from filterpy.kalman import predict as kalman_predict  # type: ignore[import-untyped]

    is_stationary = state.motion is MotionState.STANDING
    f, q = transition(state.group, is_stationary, time_s - state.time_s, float(state.x[3]), ego_is_stopped)
    x = state.x
    if is_stationary:
        x = x.copy()
        x[4:] = 0.0
    state.x, state.p = kalman_predict(x, state.p, f, q)
    state.time_s = time_s


def update(state: TrackState, detections: NoisyDetections, i: int) -> None:
    """Update a track with its assigned detection."""
    from filterpy.kalman import update as kalman_update

    z, noise = detections.z[i].copy(), detections.noise[i].copy()
    noise[4:, 4:] *= VELOCITY_CORRELATED
    noise[3, 3] *= YAW_CORRELATED
    # This comes before the update, because it compares the detection with the earlier position.
    _check_moved_while_hidden(state, detections, i)
    z[3] = state.x[3] + _heading_turn(state, float(z[3]), float(detections.score[i]))
    if state.motion is MotionState.STANDING:
        z[4:], noise[4:, 4:] = 0.0, np.eye(2) * STATIONARY_SD_MPS**2
    state.x, state.p = kalman_update(state.x, state.p, z, noise, np.eye(STATE))
    if state.heading_votes < 0.0:
        state.x[3], state.heading_votes = wrap_angle(state.x[3] + math.pi), -state.heading_votes
    if state.motion is not MotionState.STANDING and WHEELED[state.label]:
        if state.hits < AXIS_HITS:
            _turn_to_course(state)
        else:
            _constrain_to_axis(state)
    _update_size(state, detections, i)
    state.last_seen_s, state.hidden, state.concealed_s = detections.time_s, False, 0.0
    _add_sample(state, detections, i)


def _update_size(state: TrackState, detections: NoisyDetections, i: int) -> None:
    """Update the mean size. After the first measured height, the network's heights do not count."""
    last_height_m = state.size[2]
    state.size = state.size + max(1.0 / (state.hits + 1), SIZE_GAIN) * (detections.size[i] - state.size)
    if detections.height_known[i]:
        gain = max(1.0 / (state.heights + 1), SIZE_GAIN)
        state.size[2] = last_height_m + gain * (detections.size[i, 2] - last_height_m)
        state.heights += 1
    elif state.heights:
        state.size[2] = last_height_m


def wrap_angle(angle: float) -> float:
    """Return the same angle between -pi and pi (rad)."""
    return math.remainder(angle, math.tau)


def _constrain_to_axis(state: TrackState) -> None:
    """Apply the nonholonomic constraint: a vehicle moves along its axis, forward or backward.

    Velocity across the axis and yaw correct each other. Below `COURSE_MPS` there is no correction, because yaw and
    course differ.
    """
    from filterpy.kalman import update as kalman_update

    yaw, vx, vy = (float(v) for v in state.x[3:])
    along = vx * math.cos(yaw) + vy * math.sin(yaw)
    if abs(along) < COURSE_MPS:
        return
    slip_mps = vy * math.cos(yaw) - vx * math.sin(yaw)
    h = np.zeros((1, STATE))
    h[0, 3:] = -along, -math.sin(yaw), math.cos(yaw)
    expected = h @ state.x - slip_mps  # the linearized measurement, with the residual of zero slip
    noise = np.array([[SLIP_SD_MPS**2]])
    state.x, state.p = kalman_update(state.x, state.p, expected, noise, h)


def _turn_to_course(state: TrackState) -> None:
    """Turn the axis of a new vehicle to its course if that is known well. Positions are more accurate than boxes."""
    speed = math.hypot(state.x[4], state.x[5])
    spread_rad = math.sqrt(float(state.p[4, 4] + state.p[5, 5]) / 2.0) / max(speed, MIN_COURSE_MPS)
    if speed > MIN_COURSE_MPS and spread_rad < COURSE_SD_RAD:
        state.x[3] = math.atan2(state.x[5], state.x[4])
        state.p[3, :] = state.p[:, 3] = 0.0
        state.p[3, 3] = spread_rad**2
        state.heading_votes = max(state.heading_votes, COURSE_VOTE)


def _add_sample(state: TrackState, detections: NoisyDetections, i: int) -> None:
    state.hits += 1
    state.votes = state.votes * VOTES_DECAY
    state.votes[_vote_label(state, int(detections.label[i]))] += detections.score[i]
    noise, z = detections.noise[i], detections.z[i]
    state.samples[:-1] = state.samples[1:]
    position_variance, velocity_variance = (noise[0, 0] + noise[1, 1]) / 2.0, (noise[4, 4] + noise[5, 5]) / 2.0
    state.samples[-1] = detections.time_s, z[0], z[1], z[4], z[5], position_variance, velocity_variance


def _vote_label(state: TrackState, label: int) -> int:
    """Return the label that a detection votes for.

    A stationary pedestrian that has walked does not become a bicycle, because pedestrians close together look like one.
    """
    has_walked = state.label == PEDESTRIAN and state.motion is MotionState.STANDING and state.moved_at_s is not None
    return PEDESTRIAN if has_walked and LABELS[label] in state.group.labels else label


def _heading_turn(state: TrackState, yaw: float, score: float) -> float:
    """Return the turn from the track's yaw to the nearer of the measured yaw and its opposite (rad), and vote for
    one.
    """
    difference = wrap_angle(yaw - float(state.x[3]))
    opposite = abs(difference) > math.pi / 2.0
    vote = -score if opposite else score
    if math.hypot(state.x[4], state.x[5]) > COURSE_MPS and state.motion is not MotionState.STANDING:
        course = math.atan2(state.x[5], state.x[4])
        vote += COURSE_VOTE * (1.0 if math.cos(course - float(state.x[3])) > 0.0 else -1.0)
    state.heading_votes = max(-MAX_HEADING_VOTES, min(MAX_HEADING_VOTES, state.heading_votes + vote))
    return wrap_angle(difference + math.pi) if opposite else difference


def _check_moved_while_hidden(state: TrackState, detections: NoisyDetections, i: int) -> None:
    """Set a stationary track to undecided if it is detected at another position after a gap."""
    if (
        state.motion is not MotionState.STANDING
        or detections.time_s - state.last_seen_s < GAP_S
        or state.group.is_static
    ):
        return
    difference = detections.z[i, :2] - state.x[:2]
    variance = (detections.noise[i, 0, 0] + detections.noise[i, 1, 1]) / 2.0 + GAP_SHIFT_M**2
    if float(difference @ difference) > ALARM * variance:
        state.motion, state.standing_since_s, state.moved_at_s, state.standing_spell = (
            MotionState.UNDECIDED,
            None,
            detections.time_s,
            None,
        )
        state.samples[:] = -np.inf
        state.p[4:, 4:] += np.eye(2) * NEW_VELOCITY_SD_MPS**2
