"""Labeled crops from recordings, for training and checking the crop network."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stucksolver.scene.objects import ObjectKind
from stucksolver_perception.camera.crop_network import GESTURES, KINDS, LAMPS, LIGHTS, NOTHING, UNSEEN_GESTURE
from stucksolver_perception.camera.crops import CROP_PX, FEATURES, CropWindows, cut_crops, features_of, windows_of
from stucksolver_perception.camera.traffic_lights import boxes_of_heads, facing
from stucksolver_perception.measurements import Floats, Pixels, Singles
from stucksolver_perception.recording import KINDS as RECORDED_KINDS
from stucksolver_perception.recording import Recorded, Recording, recordings
from stucksolver_perception.rig import CameraRig
from stucksolver_perception.vehicle_frame import boxes_in_body
from stucksolver_perception.visible_parts import VisibleAttributes, VisibleParts

CONTEXT = 1.5
"""Side of a stored crop relative to the network's. Ours."""
STORED_PX = 96
"""Side of a stored crop (px). It is wider than the network's input (64 px), so that training can shift and scale it."""
HIDDEN_PX, HIDDEN_SHARE = 12, 0.03
"""Number of visible pixels, and share of its rectangle, below which an object counts as hidden. Ours."""
DOUBTFUL_SHARE = 0.08
"""Visible share below which an object's kind is neither a target nor counted. Ours."""
BACKGROUND = 3
"""Number of empty boxes per image. Ours."""
HEAD_HALF_M = 1.2
"""Half the side of a light's box above which the box is skipped (m). Ours.

Such a box does not enclose a single head.
"""
IGNORE, UNSEEN = -1, 2
"""Label that is ignored, and label of a hidden lamp."""


@dataclass(frozen=True, eq=False)
class Crops:
    """Crops and labels; equal lengths n. A label of -1 is neither a target nor counted."""

    crops: Pixels
    """(n, 96, 96, 3)."""
    features: Singles
    """(n, 10)."""
    kind: NDArray[np.int64]
    """Index into `KINDS`."""
    lamps: NDArray[np.int64]
    """(n, 5): 0 off, 1 on, 2 hidden."""
    lit: NDArray[np.int64]
    """(n, 5): 0 off, 1 on, visible or hidden."""
    gesture: NDArray[np.int64]
    """Index into `GESTURES`."""
    signal: NDArray[np.int64]
    """Index into `GESTURES`: the gesture of a flagger, visible or hidden."""
    light: NDArray[np.int64]
    """Index into `LIGHTS`; hidden if the head is mostly occluded or turned away."""
    state: NDArray[np.int64]
    """Index into `LIGHTS`: the state of the head, visible or hidden."""
    group: NDArray[np.int64]
    """Index of the recording."""

    def __len__(self) -> int:
        return len(self.kind)

    @property
    def middles(self) -> Pixels:
        """(n, CROP_PX, CROP_PX, 3): the crops without the margin for augmentation, as at runtime."""
        edge = (self.crops.shape[1] - CROP_PX) // 2
        return np.ascontiguousarray(self.crops[:, edge : edge + CROP_PX, edge : edge + CROP_PX])

    def subset(self, which: NDArray[np.int64] | NDArray[np.bool_]) -> Crops:
        """Return some of the crops."""
        return Crops(*(getattr(self, field.name)[which] for field in fields(self)))

    @staticmethod
    def joined(parts: Sequence[Crops]) -> Crops:
        """Return all parts joined, in order."""
        return Crops(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Crops)))


def empty() -> Crops:
    """Return no crops."""
    whole = (np.zeros((0, STORED_PX, STORED_PX, 3), np.uint8), np.zeros((0, FEATURES), np.float32))
    lamps = (np.zeros((0, len(LAMPS)), int) for _ in range(2))
    return Crops(*whole, np.zeros(0, int), *lamps, *(np.zeros(0, int) for _ in range(5)))


def crops_in(folders: Sequence[Path], jobs: int, seed: int = 0, *, flaggers: bool = False) -> Crops:
    """Read every crop of the recordings in some folders with `jobs` processes, or only those of `flaggers`.

    Raises:
        RecordingError: A folder has no recordings.
    """
    found = [recording for folder in folders for recording in recordings(folder)]
    work = [(item.folder, file, group, seed, flaggers) for group, item in enumerate(found) for file in item.files]
    if jobs <= 1:
        return Crops.joined([empty(), *map(_of_stretch, work)])
    with multiprocessing.get_context("fork").Pool(jobs) as pool:
        return Crops.joined([empty(), *pool.imap_unordered(_of_stretch, work)])


def _of_stretch(work: tuple[Path, Path, int, int, bool]) -> Crops:
    folder, file, group, seed, flaggers = work
    recording = Recording(folder)
    random = np.random.default_rng([seed, group, int(file.stem)])
    parts = [
        item
        for tick in recording.stretch(file)
        if tick.jpeg is not None and tick.instances is not None
        for item in _of_tick(tick, recording.rig.camera, group, random)
    ]
    found = Crops.joined([empty(), *parts])
    return found.subset(found.gesture >= 0) if flaggers else found


def _of_tick(tick: Recorded, rig: CameraRig, group: int, random: np.random.Generator) -> Iterator[Crops]:
    rgb, mask = tick.picture(), tick.instances
    assert rgb is not None and mask is not None
    truth = tick.truth
    boxes = boxes_in_body(tick.pose, truth.boxes[:, [0, 1, 2, 4, 5, 6, 3]])
    windows = windows_of(rig, boxes)
    keep = np.flatnonzero(windows.usable)
    if len(keep):
        each = keep.tolist()
        shares = [_visible_pixels(mask, int(truth.actor_id[i]), windows.rectangle[i]) for i in each]
        kinds = [_kind_label(_true_kind(tick, i), *visible) for i, visible in zip(each, shares, strict=True)]
        features = features_of(rig, boxes, windows)
        parts = VisibleParts(tick, rig, boxes)
        visible = [parts.get(i, windows.rectangle[i]) for i in each]
        hidden = [share < HIDDEN_SHARE for _, share in shares]
        lamps = [_lamp_labels(attributes, hidden=gone) for attributes, gone in zip(visible, hidden, strict=True)]
        gestures = [_gesture_label(attributes, hidden=gone) for attributes, gone in zip(visible, hidden, strict=True)]
        lit = [[int(attributes.truth_flags.get(name, IGNORE)) for name in LAMPS] for attributes in visible]
        signals = [
            IGNORE if attributes.shows is None else GESTURES.index(attributes.shows.value) for attributes in visible
        ]
        labels = _Labels(np.array(kinds), np.array(lamps), np.array(lit), np.array(gestures), np.array(signals))
        yield _made(rgb, windows, keep, features[keep], labels, group)
    yield from _background(rgb, rig, windows, group, random)
    yield from _lights(tick, rgb, mask, rig, group)


@dataclass(frozen=True, eq=False)
class _Labels:
    """Labels of n crops; None stands for -1 for all of them."""

    kind: NDArray[np.int64] | None = None
    lamps: NDArray[np.int64] | None = None
    lit: NDArray[np.int64] | None = None
    gesture: NDArray[np.int64] | None = None
    signal: NDArray[np.int64] | None = None
    light: NDArray[np.int64] | None = None
    state: int = IGNORE


def _made(
    rgb: Pixels, windows: CropWindows, keep: NDArray[np.int64], features: Singles, labels: _Labels, group: int
) -> Crops:
    n = len(keep)
    crops = cut_crops(rgb, windows.center[keep], windows.side[keep] * CONTEXT, STORED_PX)
    none = np.full(n, IGNORE)
    return Crops(
        crops,
        features,
        none if labels.kind is None else labels.kind,
        np.full((n, len(LAMPS)), IGNORE) if labels.lamps is None else labels.lamps,
        np.full((n, len(LAMPS)), IGNORE) if labels.lit is None else labels.lit,
        none if labels.gesture is None else labels.gesture,
        none if labels.signal is None else labels.signal,
        none if labels.light is None else labels.light,
        np.full(n, labels.state),
        np.full(n, group),
    )


def _true_kind(tick: Recorded, i: int) -> ObjectKind:
    return RECORDED_KINDS[int(tick.truth.kind[i])]


def _visible_pixels(mask: NDArray[np.uint16], actor_id: int, rectangle: Floats) -> tuple[int, float]:
    """Return the number of visible pixels of an actor in its rectangle, and their fraction of the rectangle."""
    left, top = (int(item) for item in rectangle[:2])
    right, bottom = (int(np.ceil(item)) for item in rectangle[2:])
    part = mask[top:bottom, left:right]
    own = int(np.count_nonzero(part == actor_id % 65536))
    return own, own / max(part.size, 1)


def _kind_label(kind: ObjectKind, own: int, share: float) -> int:
    if own < HIDDEN_PX or share < HIDDEN_SHARE:
        return KINDS.index(NOTHING)
    if share < DOUBTFUL_SHARE or kind is ObjectKind.UNKNOWN:
        return IGNORE
    return KINDS.index(kind.value)


def _lamp_labels(visible: VisibleAttributes, *, hidden: bool) -> list[int]:
    """Return off, on or hidden for each lamp.

    A blinker is labeled on even in its dark phases, because they look the same in one image.
    """
    if hidden:
        return [IGNORE] * len(LAMPS)
    labels = [visible.lamps.get(name, IGNORE) for name in LAMPS]
    return [UNSEEN if number is None else int(number) for number in labels]


def _gesture_label(visible: VisibleAttributes, *, hidden: bool) -> int:
    if hidden or not visible.is_flagger:
        return IGNORE
    return GESTURES.index(UNSEEN_GESTURE if visible.gesture is None else visible.gesture.value)


def _background(
    rgb: Pixels, rig: CameraRig, taken: CropWindows, group: int, random: np.random.Generator
) -> Iterator[Crops]:
    """Yield empty boxes on the ground, like a detector's false positives."""
    n = 4 * BACKGROUND
    size = np.exp(random.uniform(np.log(0.3), np.log(5.0), (n, 1))) * random.uniform(0.5, 1.0, (n, 3))
    ahead = np.exp(random.uniform(np.log(5.0), np.log(60.0), n))
    place = np.stack([ahead, ahead * random.uniform(-0.6, 0.6, n), size[:, 2] / 2.0], axis=1)
    boxes = np.concatenate([place, size, random.uniform(-np.pi, np.pi, (n, 1))], axis=1)
    windows = windows_of(rig, boxes)
    free = windows.usable.copy()
    for i in np.flatnonzero(free):
        free[i] = not len(taken.rectangle) or float(_overlap(windows.rectangle[i], taken.rectangle).max()) < 0.1
    keep = np.flatnonzero(free)[:BACKGROUND]
    if len(keep):
        labels = _Labels(np.full(len(keep), KINDS.index(NOTHING)))
        yield _made(rgb, windows, keep, features_of(rig, boxes, windows)[keep], labels, group)


def _overlap(box: Floats, others: Floats) -> Floats:
    """Return the intersection of two rectangles as a fraction of the smaller one."""
    sides = np.minimum(box[2:], others[:, 2:]) - np.maximum(box[:2], others[:, :2])
    common = np.prod(np.maximum(sides, 0.0), axis=1)
    smaller = np.minimum(np.prod(box[2:] - box[:2]), np.prod(others[:, 2:] - others[:, :2], axis=1))
    return np.asarray(common / np.maximum(smaller, 1.0))


def _lights(tick: Recorded, rgb: Pixels, mask: NDArray[np.uint16], rig: CameraRig, group: int) -> Iterator[Crops]:
    if tick.lights is None:
        return
    for light_id, state, heads in zip(tick.lights.light_id, tick.lights.state, tick.lights.heads, strict=True):
        if int(state) >= len(LIGHTS) - 1 or not len(heads) or heads[:, 3:6].max() > HEAD_HALF_M:
            continue
        moved = heads.copy()
        moved[:, 3:6] *= 2.0
        moved = boxes_in_body(tick.pose, moved)
        moved[:, 3:6] /= 2.0
        windows = windows_of(rig, boxes_of_heads(moved))
        keep = np.flatnonzero(windows.usable)
        if not len(keep):
            continue
        away = facing(rig, moved)
        shown = [_visible_pixels(mask, int(light_id), windows.rectangle[i])[1] > 0.4 and away[i] > 0.35 for i in keep]
        labels = _Labels(light=np.where(shown, int(state), len(LIGHTS) - 1), state=int(state))
        yield _made(rgb, windows, keep, np.zeros((len(keep), FEATURES), np.float32), labels, group)
