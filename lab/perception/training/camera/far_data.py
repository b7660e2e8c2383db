"""Loads strips around the horizon from recordings, with the boxes of the actors visible in them."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stucksolver.scene import ObjectKind
from stucksolver_perception.camera.crops import corners_of
from stucksolver_perception.camera.horizon_strip import STRIP_ROWS, cut_rows, strip_top
from stucksolver_perception.measurements import Floats, PoseEstimate, Singles
from stucksolver_perception.recording import KINDS, Recorded, recordings
from stucksolver_perception.rig import CameraRig
from stucksolver_perception.vehicle_frame import into_vehicle

MARGIN_ROWS = 24
"""Number of extra rows above and below the strip, so that training can cut strips at other heights."""
MOST_BOXES = 40
"""Maximum number of boxes per image, nearest first."""
LEAST_PX = 6
"""Minimum number of visible pixels of a visible actor. Ours."""
LEAST_SHARE = 0.3
"""Minimum visible share. Ours.

More occluded actors are excluded from the loss: neither positive nor negative.
"""
LARGEST_PX = 72.0
"""Largest height of a box (px). Ours.

Taller ones (cars nearer than 24 m, buses nearer than 50 m) are left to the LiDAR and excluded from the loss.
"""
NEAREST_M = 1.0
"""Least distance of an actor (m)."""
AHEAD_M = 18.0
"""Distance below which actors are left to the LiDAR and excluded from the loss (m). Ours."""
BOX_FIELDS = ("label", "left", "top", "right", "bottom", "share", "distance", "towards", "actor_id", "width_m")
"""Fields of a box.

`label`: -1 is excluded from the loss. Edges in px of the image. `towards`: 1 approaching, 0 receding, -1 crossing.
`distance`: along the ground from the vehicle's reference point to the box's center (m).
"""
_LABEL_OF = {
    **dict.fromkeys(
        (
            *(ObjectKind.CAR, ObjectKind.VAN, ObjectKind.TRUCK, ObjectKind.BUS),
            *(ObjectKind.SCHOOL_BUS, ObjectKind.EMERGENCY),
        ),
        0,
    ),
    **dict.fromkeys((ObjectKind.MOTORCYCLE, ObjectKind.BICYCLE), 1),
    **dict.fromkeys((ObjectKind.PEDESTRIAN, ObjectKind.FLAGGER), 2),
}
"""Labels by kind."""
_FILLS = (0.7, 0.45, 0.4)
"""Approximate share of its rectangle that an unoccluded actor of each label fills. Ours."""
_ACROSS = 0.5
"""Cosine between heading and line of sight below which neither front nor rear is visible. Ours."""
_ID_SPACE = 65536
"""Number of ids in a mask of 16 bits."""


@dataclass(frozen=True, eq=False)
class Strips:
    """Strips and their boxes, in arrays of equal length n."""

    rgb: NDArray[np.uint8]
    """(n, STRIP_ROWS + 2 MARGIN_ROWS, width, 3)."""
    top: NDArray[np.int64]
    """(n,): image row at which each strip starts."""
    boxes: Singles
    """(n, MOST_BOXES, 10): see `BOX_FIELDS`; padded with rows of nan."""
    time_s: Floats
    drive: NDArray[np.int64]
    """Index into `about`."""
    about: tuple[tuple[str, str], ...]
    """Town and weather of each drive."""
    rig: CameraRig

    def __len__(self) -> int:
        return len(self.rgb)


def load(folders: Sequence[Path], jobs: int) -> Strips:
    """Load all images with masks from folders of recordings.

    Raises:
        RecordingError: A folder has no recordings.
        ValueError: No image has a mask.
    """
    drives = [recording for folder in folders for recording in recordings(folder)]
    files = [(k, file) for k, drive in enumerate(drives) for file in drive.files]
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        parts = list(pool.map(_read, [(k, file.parent, file) for k, file in files]))
    parts = [part for part in parts if len(part[0])]
    if not parts:
        raise ValueError(f"no image has an instance mask: {', '.join(map(str, folders))}. Collect drives with images")
    rgb, top, boxes, time_s, drive = (np.concatenate(column) for column in zip(*parts, strict=True))
    about = tuple((_property_text(run.about, "town"), _property_text(run.about, "weather")) for run in drives)
    return Strips(rgb, top, boxes, time_s, drive, about, drives[0].rig.camera)


def boxes_of(tick: Recorded, rig: CameraRig) -> Singles:
    """Return visible actors, nearest first, as (n, 10), see `BOX_FIELDS`. The tick must have a mask."""
    assert tick.instances is not None
    x, y, z, yaw = (float(item) for item in tick.pose[:4])
    pose = PoseEstimate(tick.time_s, x, y, z, yaw, 0.0, 0.0, np.zeros((4, 4)))
    truth = tick.truth
    boxes = into_vehicle(truth.boxes[:, [0, 1, 2, 4, 5, 6, 3]], pose) if len(truth.boxes) else np.zeros((0, 7))
    boxes = _levelled(boxes, float(tick.pose[4]), float(tick.pose[5]))
    column, row, ahead = (item.reshape(-1, 8) for item in rig.project(corners_of(boxes).reshape(-1, 3)))
    counts = np.bincount(tick.instances.ravel())
    shown = {int(actor): int(counts[actor]) for actor in np.flatnonzero(counts)}
    rows: list[tuple[float, ...]] = []
    for k, actor in enumerate(truth.actor_id.tolist()):
        label = _LABEL_OF.get(KINDS[int(truth.kind[k])])
        pixels = shown.pop(actor % _ID_SPACE, 0)
        if label is None or pixels == 0 or ahead[k].min() < NEAREST_M:
            continue
        left, top = float(column[k].min()), float(row[k].min())
        right, bottom = float(column[k].max()), float(row[k].max())
        share = min(pixels / max(_FILLS[label] * (right - left) * (bottom - top), 1.0), 1.0)
        distance = float(np.hypot(boxes[k, 0], boxes[k, 1]))
        taught = pixels >= LEAST_PX and share >= LEAST_SHARE and bottom - top <= LARGEST_PX and distance >= AHEAD_M
        facing = float(np.cos(boxes[k, 6] - np.arctan2(boxes[k, 1], boxes[k, 0])))
        towards = -1 if abs(facing) < _ACROSS else int(facing < 0)
        rows.append(
            (label if taught else -1, left, top, right, bottom, share, distance, towards, actor, float(boxes[k, 4]))
        )
    rows += [_unknown(tick.instances, actor) for actor in shown if actor != 0]
    rows.sort(key=lambda item: item[6])
    return np.array(rows[:MOST_BOXES], np.float32).reshape(-1, len(BOX_FIELDS))


def _levelled(boxes: Floats, pitch_rad: float, roll_rad: float) -> Floats:
    """Return boxes in the frame of the vehicle body with its pitch (positive nose down) and roll (CARLA's sign).

    The boxes keep their upright axes: the error is below one pixel.
    """
    cp, sp, cr, sr = np.cos(pitch_rad), np.sin(pitch_rad), np.cos(roll_rad), np.sin(roll_rad)
    body = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]]) @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    moved: Floats = boxes.copy()
    moved[:, :3] = boxes[:, :3] @ body
    return moved


def _unknown(mask: NDArray[np.uint16], actor: int) -> tuple[float, ...]:
    """Return a box around an actor beyond the recorded range: excluded from the loss."""
    rows, columns = np.nonzero(mask == actor)
    edges = (float(columns.min()), float(rows.min()), float(columns.max() + 1), float(rows.max() + 1))
    return (-1.0, *edges, 0.0, np.inf, -1.0, float(actor), 0.0)


def _read(work: tuple[int, Path, Path]) -> tuple[NDArray[np.generic], ...]:
    drive, folder, file = work
    recording = recordings(folder)[0]
    rig = recording.rig.camera
    top = strip_top(rig) - MARGIN_ROWS
    rgb, boxes, times = [], [], []
    for tick in recording.stretch(file):
        if tick.instances is None or (picture := tick.picture()) is None:
            continue
        rgb.append(cut_rows(picture, top, STRIP_ROWS + 2 * MARGIN_ROWS))
        found = boxes_of(tick, rig)
        padded = np.full((MOST_BOXES, len(BOX_FIELDS)), np.nan, np.float32)
        padded[: len(found)] = found
        boxes.append(padded)
        times.append(tick.time_s)
    if not rgb:
        return (np.zeros(0),) * 5
    n = len(rgb)
    return np.array(rgb), np.full(n, top), np.array(boxes), np.array(times), np.full(n, drive)


def _property_text(about: dict[str, object], name: str) -> str:
    """Return a property of a drive as text. On routes, `weather` may be a record of values; then it is "other"."""
    value = about.get(name, "unknown")
    return value if isinstance(value, str) else "other"
