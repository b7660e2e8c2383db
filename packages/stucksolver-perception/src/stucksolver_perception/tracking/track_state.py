"""One object inside the tracker: its Kalman filter, its votes, its last detections."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Floats
from stucksolver_perception.tracking.motion_groups import GROUP_OF_LABEL, GROUPS, WHEELED, MotionGroup
from stucksolver_perception.tracking.motion_prediction import STATE, transition
from stucksolver_perception.tracking.noise import VELOCITY_LOOKS, YAW_LOOKS, NoisyDetections
from stucksolver_perception.tracking.stationarity import ALARM, SAMPLES, MotionState
from stucksolver_perception.tracking.track import KEPT, Track

STANDING_VELOCITY_MPS = 0.03
"""Standard deviation of the velocity of a standing object: a zero-velocity update instead of the measurement."""
NEW_VELOCITY_MPS = 0.5
"""A newly measured velocity may be wrong by this much, since it is changing."""
VOTES_PRIOR = 0.5
VOTES_FORGET = 0.98
"""Weight of a vote one look later; at 10 Hz it halves in 3.4 s."""
SIZE_GAIN = 0.05
"""The size is the mean of the first 20 looks, then a running mean with this gain."""
COURSE_MPS = 1.5
"""Above this speed the course tells front from back."""
COURSE_VOTE = 3.0
SLIP_MPS = 0.3
"""How fast the middle of a moving vehicle may slide across its own axis: in turns it does so by yaw rate times the
distance to the rear axle.
"""
AXIS_LOOKS = 10
"""In so many first looks the box says little about the axis: of a fast vehicle it is drawn askew, by up to 90 degrees
for a truck at 60 km/h. If its velocity were forced into that axis, every few looks would start another track.
"""
COURSE_KNOWN_RAD = 0.25
"""Until then its axis is its course, once that is known this well (standard deviation)."""
COURSE_FROM_MPS = 3.0
"""Nobody backs up faster than this."""
HEADING_VOTES = 10.0
"""At most this many votes are kept for a heading, so that an error can be corrected."""
CERTAIN = 5.0
"""Largest log-odds of existence: 99.3 %."""
REGAINED_S = 0.5
"""After a gap of this length a standing object is compared with its earlier position."""
REGAINED_M = 0.3
"""Another side of it is visible then: its center may be measured this much elsewhere."""


PEDESTRIAN = LABELS.index("pedestrian")
STIRRED_M, STIRRED_S = 0.5, 10.0
"""Whoever comes to rest this near to where it stood, within this time, has not moved: boxes wander while the ego turns
or backs up.
"""
SHIFTED_M, STEP_M = 0.5, 0.15
"""A thing moves if its place has shifted by the first distance over its last looks, by at least the second in each half
of them. The detector takes one thing for its neighbor, or a part of a passing car for a thing: that is a jump.
"""
FEW = 3
"""Looks whose median is one place; three places are compared."""


@dataclass(frozen=True)
class StandingSpell:
    """A place where an object stood, and what was known of it then."""

    x_m: float
    y_m: float
    since_s: float
    moved_at_s: float | None
    left_s: float
    """When it was taken to move."""


@dataclass(eq=False)
class TrackState:
    """Changed only by the tracker; `track` returns its present values."""

    id: int
    x: Floats
    """(6,): x, y, z, yaw, vx, vy."""
    p: Floats
    """(6, 6)."""
    size: Floats
    time_s: float
    first_seen_s: float
    last_seen_s: float
    hits: int = 0
    heights: int = 0
    """Looks in which its height was measured."""
    odds: float = 0.0
    """Logarithm of the odds that it exists."""
    scores: float = 0.0
    """Sum of the scores of all its detections."""
    strength: float = 0.0
    """Running mean of the scores of the last looks, where a miss counts as 0."""
    hidden: bool = False
    looked_s: float = 0.0
    """Time of the look before this one."""
    concealed_s: float = 0.0
    """How long the standing ego itself has hidden it since it was last detected (s)."""
    motion: MotionState = MotionState.UNDECIDED
    standing_since_s: float | None = None
    moved_at_s: float | None = None
    stood: StandingSpell | None = None
    """Where it stood before it was taken to move."""
    heading_votes: float = 0.0
    """Above 0: the yaw is right; below: it is the opposite."""
    votes: Floats = field(default_factory=lambda: np.zeros(len(LABELS)))
    samples: Floats = field(default_factory=lambda: np.full((SAMPLES, 7), -np.inf))

    @property
    def label(self) -> int:
        """The label with the most votes."""
        return int(self.votes.argmax())

    @property
    def group(self) -> MotionGroup:
        """How objects of its kind move."""
        return GROUPS[GROUP_OF_LABEL[self.label]]

    @property
    def confidence(self) -> float:
        """Probability that it exists."""
        return 1.0 / (1.0 + math.exp(-self.odds))

    def track(self) -> Track:
        """Return the present values."""
        stands = self.motion is MotionState.STANDING
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
            vx_mps=0.0 if stands else float(self.x[4]),
            vy_mps=0.0 if stands else float(self.x[5]),
            length_m=float(self.size[0]),
            width_m=float(self.size[1]),
            height_m=float(self.size[2]),
            covariance=self.p[np.ix_(KEPT, KEPT)],
            first_seen_s=self.first_seen_s,
            last_seen_s=self.last_seen_s,
            hits=self.hits,
            hidden=self.hidden,
            standing_since_s=self.standing_since_s,
            moved_at_s=self.moved_at_s,
        )


def new_track(number: int, seen: NoisyDetections, i: int) -> TrackState:
    """Return a body from its first detection."""
    p = seen.noise[i].copy()
    p[4:, 4:] += np.eye(2) * NEW_VELOCITY_MPS**2
    body = TrackState(number, seen.z[i].copy(), p, seen.size[i].copy(), seen.time_s, seen.time_s, seen.time_s)
    _remember(body, seen, i)
    body.heights = int(seen.height_known[i])
    if body.group.lifeless:
        body.motion, body.standing_since_s, body.x[4:] = MotionState.STANDING, seen.time_s, 0.0
    return body


def may_move(body: TrackState) -> bool:
    """Return True unless it is a thing whose place has not shifted steadily."""
    if not body.group.lifeless:
        return True
    places = body.samples[np.isfinite(body.samples[:, 0]), 1:3][-3 * FEW :]
    if len(places) < 3 * FEW:
        return False
    first, middle, last = (np.median(part, axis=0) for part in np.split(places, 3))
    whole = last - first
    way_m = float(np.hypot(*whole))
    return way_m > SHIFTED_M and all(float(half @ whole) > STEP_M * way_m for half in (middle - first, last - middle))


def start_moving(body: TrackState, now_s: float) -> None:
    """Note that a body moves; remember where it stood."""
    if body.stood is not None and now_s - body.stood.left_s > STIRRED_S:
        body.stood = None
    if body.stood is None and body.standing_since_s is not None:
        body.stood = StandingSpell(float(body.x[0]), float(body.x[1]), body.standing_since_s, body.moved_at_s, now_s)
    body.motion, body.standing_since_s, body.moved_at_s = MotionState.MOVING, None, now_s


def stop_moving(body: TrackState, since_s: float) -> None:
    """Note that a body has stood since a time (s); if it has come back to where it stood, it has stood all the time."""
    body.motion, body.standing_since_s = MotionState.STANDING, since_s
    stood = body.stood
    back = stood is not None and math.hypot(body.x[0] - stood.x_m, body.x[1] - stood.y_m) < STIRRED_M
    if stood is not None and back and body.time_s - stood.left_s < STIRRED_S:
        body.standing_since_s, body.moved_at_s = stood.since_s, stood.moved_at_s
    elif body.moved_at_s is not None:
        body.moved_at_s = min(body.moved_at_s, since_s)


def predict(body: TrackState, time_s: float, held: bool = False) -> None:
    """Predict a body to a time. `held`: the ego stands, so that its pose does not drift."""
    from filterpy.kalman import predict as kalman_predict  # type: ignore[import-untyped]

    stands = body.motion is MotionState.STANDING
    f, q = transition(body.group, stands, time_s - body.time_s, float(body.x[3]), held)
    x = body.x
    if stands:
        x = x.copy()
        x[4:] = 0.0
    body.x, body.p = kalman_predict(x, body.p, f, q)
    body.time_s = time_s


def update(body: TrackState, seen: NoisyDetections, i: int) -> None:
    """Update a body with its assigned detection."""
    from filterpy.kalman import update as kalman_update

    z, noise = seen.z[i].copy(), seen.noise[i].copy()
    noise[4:, 4:] *= VELOCITY_LOOKS
    noise[3, 3] *= YAW_LOOKS
    _regain(body, seen, i)
    z[3] = body.x[3] + _same_heading(body, float(z[3]), float(seen.score[i]))
    if body.motion is MotionState.STANDING:
        z[4:], noise[4:, 4:] = 0.0, np.eye(2) * STANDING_VELOCITY_MPS**2
    body.x, body.p = kalman_update(body.x, body.p, z, noise, np.eye(STATE))
    if body.heading_votes < 0.0:
        body.x[3], body.heading_votes = wrap_angle(body.x[3] + math.pi), -body.heading_votes
    if body.motion is not MotionState.STANDING and WHEELED[body.label]:
        if body.hits < AXIS_LOOKS:
            _along_its_course(body)
        else:
            _along_its_axis(body)
    _resize(body, seen, i)
    body.last_seen_s, body.hidden, body.concealed_s = seen.time_s, False, 0.0
    _remember(body, seen, i)


def _resize(body: TrackState, seen: NoisyDetections, i: int) -> None:
    """Update the mean size. Once its height has been measured, guesses of it no longer count."""
    before_m = body.size[2]
    body.size = body.size + max(1.0 / (body.hits + 1), SIZE_GAIN) * (seen.size[i] - body.size)
    if seen.height_known[i]:
        gain = max(1.0 / (body.heights + 1), SIZE_GAIN)
        body.size[2] = before_m + gain * (seen.size[i, 2] - before_m)
        body.heights += 1
    elif body.heights:
        body.size[2] = before_m


def wrap_angle(angle: float) -> float:
    """Return the same angle between -pi and pi (rad)."""
    return math.remainder(angle, math.tau)


def _along_its_axis(body: TrackState) -> None:
    """Apply the nonholonomic constraint: what has wheels moves along its axis, forward or backward.

    Speed across the axis and yaw correct each other this way. Below `COURSE_MPS` the yaw says little about the course.
    """
    from filterpy.kalman import update as kalman_update

    yaw, vx, vy = (float(v) for v in body.x[3:])
    along = vx * math.cos(yaw) + vy * math.sin(yaw)
    if abs(along) < COURSE_MPS:
        return
    sliding = vy * math.cos(yaw) - vx * math.sin(yaw)
    h = np.zeros((1, STATE))
    h[0, 3:] = -along, -math.sin(yaw), math.cos(yaw)
    expected = h @ body.x - sliding  # the linearised measurement whose residual is that of zero sliding
    noise = np.array([[SLIP_MPS**2]])
    body.x, body.p = kalman_update(body.x, body.p, expected, noise, h)


def _along_its_course(body: TrackState) -> None:
    """Turn the axis of a new body to its course, as far as that is known: its places say more than its boxes."""
    speed = math.hypot(body.x[4], body.x[5])
    spread_rad = math.sqrt(float(body.p[4, 4] + body.p[5, 5]) / 2.0) / max(speed, COURSE_FROM_MPS)
    if speed > COURSE_FROM_MPS and spread_rad < COURSE_KNOWN_RAD:
        body.x[3] = math.atan2(body.x[5], body.x[4])
        body.p[3, :] = body.p[:, 3] = 0.0
        body.p[3, 3] = spread_rad**2
        body.heading_votes = max(body.heading_votes, COURSE_VOTE)


def _remember(body: TrackState, seen: NoisyDetections, i: int) -> None:
    body.hits += 1
    body.votes = body.votes * VOTES_FORGET
    body.votes[_voted(body, int(seen.label[i]))] += seen.score[i]
    noise, z = seen.noise[i], seen.z[i]
    body.samples[:-1] = body.samples[1:]
    place, speed = (noise[0, 0] + noise[1, 1]) / 2.0, (noise[4, 4] + noise[5, 5]) / 2.0
    body.samples[-1] = seen.time_s, z[0], z[1], z[4], z[5], place, speed


def _voted(body: TrackState, label: int) -> int:
    """Return the label that a detection votes for. Who has walked here and stands does not become a bicycle: people who
    stand close together look like one.
    """
    walked = body.label == PEDESTRIAN and body.motion is MotionState.STANDING and body.moved_at_s is not None
    return PEDESTRIAN if walked and LABELS[label] in body.group.labels else label


def _same_heading(body: TrackState, yaw: float, score: float) -> float:
    """Return the turn of the track's yaw to the measured yaw or its opposite, whichever is nearer, and vote on
    which.
    """
    off = wrap_angle(yaw - float(body.x[3]))
    opposite = abs(off) > math.pi / 2.0
    vote = -score if opposite else score
    if math.hypot(body.x[4], body.x[5]) > COURSE_MPS and body.motion is not MotionState.STANDING:
        course = math.atan2(body.x[5], body.x[4])
        vote += COURSE_VOTE * (1.0 if math.cos(course - float(body.x[3])) > 0.0 else -1.0)
    body.heading_votes = max(-HEADING_VOTES, min(HEADING_VOTES, body.heading_votes + vote))
    return wrap_angle(off + math.pi) if opposite else off


def _regain(body: TrackState, seen: NoisyDetections, i: int) -> None:
    """Return True if a stationary object is seen again elsewhere: it has moved unseen."""
    if body.motion is not MotionState.STANDING or seen.time_s - body.last_seen_s < REGAINED_S or body.group.lifeless:
        return
    off = seen.z[i, :2] - body.x[:2]
    variance = (seen.noise[i, 0, 0] + seen.noise[i, 1, 1]) / 2.0 + REGAINED_M**2
    if float(off @ off) > ALARM * variance:
        body.motion, body.standing_since_s, body.moved_at_s, body.stood = MotionState.UNDECIDED, None, seen.time_s, None
        body.samples[:] = -np.inf
        body.p[4:, 4:] += np.eye(2) * NEW_VELOCITY_MPS**2
