"""Which tracks are kept: those detected, and those that could not have been detected."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.free_space import FreeSpace, footprints, within
from stucksolver_perception.measurements import Floats, PoseEstimate
from stucksolver_perception.rig import LidarRig
from stucksolver_perception.tracking.motion_groups import WHEELED
from stucksolver_perception.tracking.stationarity import MotionState
from stucksolver_perception.tracking.track_state import CERTAIN, TrackState
from stucksolver_perception.vehicle_frame import into_vehicle

FOUND_NEAR = (0.6, 0.6, 0.6, 0.6, 0.4, 0.6, 0.6, 0.4)
"""(labels,): probability that a visible object close by is detected in one look. Lower than the measured recall (see
`noise.py`: 0.96 for cars, 0.98 for trucks), because misses come in rows: five looks at one object are not five
independent chances."""
FOUND_FAR = (0.4, 0.35, 0.3, 0.35, 0.2, 0.4, 0.3, 0.15)
"""The same at the end of its group's `range_m`, where 0.93 of the cars and 0.7 of the trucks are found."""
FOUND_UNSURE = 0.25
"""The same if something is there, or no ray came back, and nothing nearer hides it: the detector had its points and
found no object in them. This ends the tracks of walls and hedges that were once taken for an object.
"""
GONE = -1.5
"""Log-odds of existence below which a track ends (18 %)."""
UNCONFIRMED_S = 0.35
"""An object seen only once is dropped after this time."""
SURE_HIT = 0.95
"""No single detection counts for more than this."""
NOWHERE_M = 2.5
"""A hidden object whose place is known no better than this (standard deviation) is forgotten: it may be anywhere that
is not seen, and what is not seen does not count as free anyway.
"""
STRENGTH_GAIN = 0.2
"""Gain of the running mean of scores: about the last five looks."""
HEADROOM = 2.0
"""How much the log-odds may exceed those of the mean score: an object that is found only weakly, in every second look,
never becomes certain.
"""
NEARER_M = 0.5
"""What hides an object is at least this much nearer than its front."""
LOW_M, LOW_THING_M = 0.5, 1.0
"""The rays that show a place to be free may pass above something lower (`visibility.HEIGHT_M`). A thing of the second
height does not run away: a cone that a passing car hides for a moment, or that is found only now and then, is kept.
"""
SHORT_M = 1.0
"""The box of a long vehicle may end this much too early (m): the network sees its rear only."""
BOX_MARGIN_M = 0.2
"""Returns from within this margin around a box come from its object (m), ..."""
LOW_SHARE = 0.3
"""... if they are higher than this share of its height."""
FEWEST_RETURNS = 12
"""This many of them show that a vehicle is still there, ..."""
FEWEST_OF_A_THING = 4
"""... and this many for anything else."""
WAY_M = 1.5
"""Half the width of the vehicle's way (m)."""
CONCEALED_M = 5.0
"""The LiDAR's lowest beam passes above low things that are nearer than this (m)."""
CONCEALED_SCORE = 5.0
"""Sum of the scores of the looks at a thing that is surely there: ten good looks. Now and then the network sees a thing
where none is.
"""
OCCLUSION_MARGIN = 0.8
"""Share of an object's width that must be covered by a nearer one for it to count as hidden."""


def hit(body: TrackState, score: float) -> None:
    """Update a body to which a detection with this score was assigned."""
    share = min(SURE_HIT, max(0.05, score))
    body.strength = score if body.hits <= 1 else body.strength + STRENGTH_GAIN * (score - body.strength)
    mean = min(SURE_HIT, max(0.05, body.strength))
    most = min(CERTAIN, math.log(mean / (1.0 - mean)) + HEADROOM)
    body.odds = min(most, body.odds + math.log(share / (1.0 - share)) + 1.0)


def miss(body: TrackState, distance_m: float, free: bool) -> None:
    """Update a body that could have been detected but was not. `free`: its place was seen to be free or is taken."""
    far = min(1.0, distance_m / body.group.range_m)
    near, farthest = FOUND_NEAR[body.label], FOUND_FAR[body.label]
    found = near + (farthest - near) * far if free else min(FOUND_UNSURE, near)
    body.hidden = False
    body.strength *= 1.0 - STRENGTH_GAIN
    body.odds += math.log(1.0 - found)


def keep_occluded(body: TrackState, distance_m: float, now_s: float) -> None:
    """Note that the standing ego's own nose hides a thing: what is surely there is not forgotten, or the ego would set
    off over it.
    """
    if body.group.lifeless and distance_m < CONCEALED_M and body.scores >= CONCEALED_SCORE:
        body.concealed_s += now_s - body.looked_s


def tracks_explaining_returns(bodies: list[TrackState], pose: PoseEstimate, standing: Floats) -> dict[int, float]:
    """Return the ids of those from which some of the returns come, and their odds.

    Close behind a van, or before a box on the road, the network at times misses it for a second. It still returns rays,
    so that something stands there. Beside the vehicle's way this holds for vehicles only: curbs and hedges return rays
    as well, where a thing was seen by mistake.

    Args:
        bodies: Those that stand.
        pose: Of the vehicle.
        standing: (m, 3): x, y (m, vehicle frame) and height above ground (m) of returns that stand up.
    """
    found = {}
    boxes = into_vehicle(np.array([(*b.x[:3], *b.size, b.x[3]) for b in bodies]).reshape(-1, 7), pose)
    for body, place in zip(bodies, footprints(boxes), strict=True):
        wheeled = WHEELED[body.label]
        if not wheeled and abs(place[1]) > WAY_M:
            continue
        inside = within(place[None], standing[:, 0], standing[:, 1], BOX_MARGIN_M, BOX_MARGIN_M)
        inside &= standing[:, 2] > LOW_SHARE * body.size[2]
        if inside.sum() >= (FEWEST_RETURNS if wheeled else FEWEST_OF_A_THING):
            found[body.id] = body.odds
    return found


def explained_by(found: list[TrackState], pose: PoseEstimate, standing: Floats) -> NDArray[np.bool_]:
    """(m,): True for the returns (see `tracks_explaining_returns`) that come from one of the detected bodies."""
    boxes = into_vehicle(np.array([(*b.x[:3], *b.size, b.x[3]) for b in found]).reshape(-1, 7), pose)
    return within(footprints(boxes), standing[:, 0], standing[:, 1], SHORT_M, BOX_MARGIN_M)


def ended(body: TrackState, now_s: float, confirmed: bool) -> bool:
    """Return True if a body is to be dropped."""
    unseen_s = now_s - body.last_seen_s - body.concealed_s
    if body.odds < GONE or (not confirmed and unseen_s > UNCONFIRMED_S):
        return True
    if body.hidden and float(np.linalg.eigvalsh(body.p[:2, :2])[-1]) > NOWHERE_M**2:
        return True
    standing = body.motion is MotionState.STANDING
    return unseen_s > (body.group.remembered_standing_s if standing else body.group.remembered_moving_s)


def undetectable(
    bodies: list[TrackState], others: list[TrackState], pose: PoseEstimate, lidar: LidarRig, space: FreeSpace | None
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return two masks (bodies,): bodies that could not be detected, and those whose place is known to be free.

    A body cannot be detected outside the LiDAR's cone or range, or if something nearer hides it: a tall return in
    `space`, or without `space` one of `others`. A body whose center is in seen space would have blocked the rays that
    passed there, unless it is low; without `space` every place counts as free.
    """
    x, y, size = _in_sensor(bodies, pose, lidar)
    distance = np.hypot(x, y)
    reach = np.array([body.group.range_m for body in bodies])
    up = lidar.mount.z_m
    # The lowest beam passes over low objects nearby.
    lowest = up - np.maximum(0.0, distance - size[:, 0] / 2) * math.tan(math.radians(-lidar.lower_deg))
    hidden: NDArray[np.bool_] = (distance > np.minimum(reach, lidar.range_m)) | (lowest > size[:, 2])
    free: NDArray[np.bool_] = np.ones(len(bodies), np.bool_)
    if space is not None:
        mount, count = lidar.mount, len(space.blocked_m)
        low = np.array([LOW_THING_M if body.group.lifeless else LOW_M for body in bodies])
        free = space.is_proven_free(x + mount.x_m, y + mount.y_m) & (size[:, 2] >= low)
        bins = ((np.arctan2(y, x) + math.pi) / math.tau * count).astype(np.int64) % count
        front = distance - np.hypot(size[:, 0], size[:, 1]) / 2 - NEARER_M
        return hidden | (~free & (space.blocked_m[bins] < front)), free
    if others:
        hidden |= _shadowed(x, y, size, *_in_sensor(others, pose, lidar), up)
    return hidden, free


def _in_sensor(bodies: list[TrackState], pose: PoseEstimate, lidar: LidarRig) -> tuple[Floats, Floats, Floats]:
    """Return x, y (n, 2) of each body from the LiDAR's foot, along the vehicle's axes (m), and sizes (n, 3) (m)."""
    state = np.array([body.x[:2] for body in bodies])
    dx, dy = state[:, 0] - pose.x_m, state[:, 1] - pose.y_m
    cos, sin = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    x = dx * cos + dy * sin - lidar.mount.x_m
    y = dy * cos - dx * sin - lidar.mount.y_m
    return x, y, np.array([body.size for body in bodies])


def _shadowed(
    x: Floats, y: Floats, size: Floats, by_x: Floats, by_y: Floats, by_size: Floats, up: float
) -> NDArray[np.bool_]:
    """(n,): True if it is in the shadow of one of the others, seen from `up` meters above the ground.

    A body's apparent width is taken as the mean of its length and width. It hides another if it is nearer, covers
    most of its directions, and the line from the sensor over its top passes above the other's top.
    """
    far, near = np.hypot(x, y), np.maximum(0.5, np.hypot(by_x, by_y))
    half = np.arctan2((size[:, 0] + size[:, 1]) / 4, np.maximum(0.5, far))
    by_half = np.arctan2((by_size[:, 0] + by_size[:, 1]) / 4, near)
    between = np.abs((np.arctan2(y, x)[:, None] - np.arctan2(by_y, by_x)[None] + np.pi) % (2 * np.pi) - np.pi)
    covered = between + OCCLUSION_MARGIN * half[:, None] <= by_half[None]
    nearer = near[None] + by_size[None, :, :2].min(-1) / 2 < far[:, None]
    over = (up - by_size[:, 2])[None] / near[None] <= (up - size[:, 2])[:, None] / np.maximum(0.5, far)[:, None]
    return np.asarray((covered & nearer & over).any(1))
