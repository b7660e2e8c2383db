"""Reads and writes recordings of drives: sensor data with ground truth, for training, scoring and inspection.

A recording is a folder: `drive.json` (version, town, weather, rig, what was driven) and one `NNNNN.npz` for each
stretch of some seconds. It contains no roles of actors.
"""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from stucksolver.scene.objects import Gesture, ObjectKind
from stucksolver_perception.measurements import Floats, LidarSweep, Pixels
from stucksolver_perception.rig import Rig

VERSION = 2
"""Version of the format."""
CENTIMETERS_PER_M = 100.0
"""Factor from a point's coordinates (m) to the stored integers (cm)."""
PARTS = ("brake_lights", "left_blinker", "right_blinker", "emergency_lights", "door_open")
"""Lamps and doors, in the order of the bits of `Truth.shown`."""
KINDS = tuple(ObjectKind)
"""The kinds by the index in `Truth.kind`."""
GESTURES = tuple(Gesture)
"""The gestures by the index in `Truth.gesture`."""
BOX_COLUMNS = ("x", "y", "z", "yaw", "length", "width", "height", "vx", "vy")
"""Columns of a box: center in the local frame, yaw, size and velocity (m, rad, m/s)."""


class RecordingError(ValueError):
    """A folder is not a recording, or has another version. The message names the folder and the remedy."""


@dataclass(frozen=True, eq=False)
class Truth:
    """Ground truth of all objects around the ego on one tick, in the local frame; equal lengths n."""

    actor_id: NDArray[np.int64]
    """(n,): id of the actor."""
    kind: NDArray[np.int64]
    """(n,): index into `KINDS`."""
    boxes: Floats
    """(n, 9): see `BOX_COLUMNS`."""
    lamps: NDArray[np.int64]
    """(n,): bits of `carla.VehicleLightState`; -1 for an object without lamps."""
    doors: NDArray[np.int64]
    """(n,): open side doors, bit `1 << n` for the n-th of `carla.VehicleDoor`; -1 if unknown."""
    gesture: NDArray[np.int64]
    """(n,): index into `GESTURES` of a flagger's gesture; -1 if unknown, or for another object."""
    shown: NDArray[np.int64]
    """(n,): lamps and doors that are visible to the camera, lit or not: bits in the order of `PARTS`; -1 if not
    measured."""
    type_id: tuple[str, ...]
    """Blueprints, for the analysis of errors. Training does not use them."""


@dataclass(frozen=True, eq=False)
class LightTruth:
    """Ground truth of the traffic lights within reach on one tick."""

    light_id: NDArray[np.int64]
    """(n,): id of the light."""
    state: NDArray[np.int64]
    """(n,): 0 red, 1 yellow, 2 green, 3 off, 4 unknown."""
    heads: tuple[Floats, ...]
    """For each light (k, 7): center x, y, z of each of its heads, half sizes x, y, z, and yaw in the local frame."""


@dataclass(frozen=True, eq=False)
class Recorded:
    """One tick."""

    time_s: float
    pose: Floats
    """(9,): ground truth x, y, z, yaw, pitch, roll of the ego's reference point, speed, yaw rate, lateral speed."""
    sweep: LidarSweep
    """Points of the LiDAR in the vehicle frame."""
    imu: Floats
    """(7,): measured accelerations, turn rates and compass."""
    gnss: Floats
    """(3,): measured position in the local frame (m)."""
    wheel_mps: float
    """Measured speed of the wheels (m/s)."""
    truth: Truth
    lights: LightTruth | None
    """The lights; recorded only on ticks with an image."""
    jpeg: bytes | None
    """The front camera's image; None on ticks without one."""
    instances: NDArray[np.uint16] | None
    """(height, width): actor id of each pixel, 0 for none (`carla` instance camera, modulo 65536); None without a
    mask."""

    def picture(self) -> Pixels | None:
        """Return (height, width, 3): the image as RGB; None without one."""
        if self.jpeg is None:
            return None
        from PIL import Image

        return np.asarray(Image.open(io.BytesIO(self.jpeg)).convert("RGB"))


@dataclass
class RecordingWriter:
    """Writer of one drive. Call `add` on every tick, and `close` at the end."""

    folder: Path
    rig: Rig
    about: dict[str, Any]
    """Town, weather and similar facts, for sorting recordings."""
    ticks_in_file: int = 100
    """Number of ticks in a file."""
    _ticks: list[Recorded] = field(default_factory=list)
    _files: int = 0
    """Number of written files."""

    def __post_init__(self) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        about = {"version": VERSION, "rig": self.rig.model_dump(), **self.about}
        (self.folder / "drive.json").write_text(json.dumps(about, indent=1) + "\n", encoding="utf-8")

    def add(self, tick: Recorded) -> None:
        """Add the next tick, in order of time."""
        self._ticks.append(tick)
        if len(self._ticks) >= self.ticks_in_file:
            self._flush()

    def close(self) -> None:
        """Write the remaining ticks."""
        if self._ticks:
            self._flush()

    def _flush(self) -> None:
        target = self.folder / f"{self._files:05d}.npz"
        # A process that ends while it writes leaves a `.part` file, which readers ignore.
        part = target.with_suffix(".part")
        with part.open("wb") as stream:
            np.savez(stream, **_packed(self._ticks))
        part.replace(target)
        self._ticks, self._files = [], self._files + 1


class Recording:
    """Reader of one drive.

    Raises:
        RecordingError: The folder is not a recording.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        try:
            about = json.loads((folder / "drive.json").read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise RecordingError(f"{folder}: this folder is not a recording ({error})") from error
        if not isinstance(about, dict):
            raise RecordingError(f"{folder}: this folder is not a recording (its drive.json has no table)")
        if about.get("version") != VERSION:
            raise RecordingError(
                f"{folder}: recorded in format {about.get('version')}, expected {VERSION}; record it again"
            )
        try:
            self.rig = Rig.model_validate(about.pop("rig", None))
        except ValidationError as error:
            first = error.errors()[0]
            key = ".".join(str(part) for part in ("rig", *first["loc"]))
            raise RecordingError(f"{folder}: drive.json: {key}: {first['msg']}; record it again") from error
        self.about: dict[str, Any] = about
        self._files = sorted(folder.glob("[0-9]*.npz"))

    def __iter__(self) -> Iterator[Recorded]:
        """Yield all ticks in order of time."""
        for file in self._files:
            yield from self.stretch(file)

    @property
    def files(self) -> Sequence[Path]:
        """The files of the stretches in order of time."""
        return self._files

    def stretch(self, file: Path) -> Iterator[Recorded]:
        """Yield the ticks of one stretch."""
        with np.load(file, allow_pickle=False) as arrays:
            yield from _unpacked({name: arrays[name] for name in arrays.files})


def recordings(folder: Path) -> list[Recording]:
    """Return all recordings in a folder, or the folder itself if it is one.

    Raises:
        RecordingError: The folder contains no recording.
    """
    if (folder / "drive.json").is_file():
        return [Recording(folder)]
    readers = [Recording(file.parent) for file in sorted(folder.glob("**/drive.json"))]
    if not readers:
        raise RecordingError(f"{folder}: no recordings found; make some with `python -m lab perception collect`")
    return readers


def _packed(ticks: Sequence[Recorded]) -> dict[str, Any]:
    sweeps = [tick.sweep.points for tick in ticks]
    points = np.concatenate(sweeps) if sweeps else np.zeros((0, 4), np.float32)
    truths = [tick.truth for tick in ticks]
    lit = [(i, tick.lights) for i, tick in enumerate(ticks) if tick.lights is not None]
    heads = [head for _, lights in lit for head in lights.heads]
    images = [(i, tick.jpeg) for i, tick in enumerate(ticks) if tick.jpeg is not None]
    masks = [(i, tick.instances) for i, tick in enumerate(ticks) if tick.instances is not None]
    packed: dict[str, Any] = {
        "time_s": np.array([tick.time_s for tick in ticks]),
        "pose": np.array([tick.pose for tick in ticks]),
        "imu": np.array([tick.imu for tick in ticks]),
        "gnss": np.array([tick.gnss for tick in ticks]),
        "wheel_mps": np.array([tick.wheel_mps for tick in ticks]),
        "points": np.clip(np.round(points[:, :3] * CENTIMETERS_PER_M), -32768, 32767).astype(np.int16),
        "intensity": np.round(points[:, 3] * 255.0).astype(np.uint8),
        "swept": np.array([len(sweep) for sweep in sweeps]),
        "actor_id": np.concatenate([truth.actor_id for truth in truths]).astype(np.int64),
        "kind": np.concatenate([truth.kind for truth in truths]).astype(np.int16),
        "boxes": np.concatenate([truth.boxes for truth in truths]).astype(np.float32),
        "lamps": np.concatenate([truth.lamps for truth in truths]).astype(np.int32),
        "doors": np.concatenate([truth.doors for truth in truths]).astype(np.int8),
        "gesture": np.concatenate([truth.gesture for truth in truths]).astype(np.int8),
        "shown": np.concatenate([truth.shown for truth in truths]).astype(np.int8),
        "type_id": np.array([name for truth in truths for name in truth.type_id] or [""]),
        "bodies": np.array([len(truth.actor_id) for truth in truths]),
        "lit": np.array([i for i, _ in lit], np.int64),
        "light_id": np.concatenate([np.zeros(0, np.int64), *(lights.light_id for _, lights in lit)]),
        "light_state": np.concatenate([np.zeros(0, np.int64), *(lights.state for _, lights in lit)]),
        "lights": np.array([len(lights.light_id) for _, lights in lit], np.int64),
        "heads": np.concatenate([np.zeros((0, 7)), *heads]).astype(np.float32),
        "headed": np.array([len(head) for head in heads], np.int64),
        "drawn": np.array([i for i, _ in images], np.int64),
        "jpeg": np.frombuffer(b"".join(jpeg for _, jpeg in images), np.uint8),
        "jpegs": np.array([len(jpeg) for _, jpeg in images], np.int64),
        "masked": np.array([i for i, _ in masks], np.int64),
    }
    for i, mask in masks:
        packed[f"instances_{i}"] = np.frombuffer(_png(mask), np.uint8)
    return packed


def _unpacked(a: dict[str, NDArray[Any]]) -> Iterator[Recorded]:
    swept, bodies = _starts(a["swept"]), _starts(a["bodies"])
    lights, headed, jpegs = _starts(a["lights"]), _starts(a["headed"]), _starts(a["jpegs"])
    lit = {int(i): k for k, i in enumerate(a["lit"])}
    drawn = {int(i): k for k, i in enumerate(a["drawn"])}
    masked = set(a["masked"].tolist())
    for i, time_s in enumerate(a["time_s"].tolist()):
        span, objects = slice(swept[i], swept[i + 1]), slice(bodies[i], bodies[i + 1])
        points = np.empty((swept[i + 1] - swept[i], 4), np.float32)
        points[:, :3] = a["points"][span] / np.float32(CENTIMETERS_PER_M)
        points[:, 3] = a["intensity"][span] / np.float32(255.0)
        truth = Truth(
            a["actor_id"][objects],
            a["kind"][objects].astype(np.int64),
            a["boxes"][objects].astype(np.float64),
            a["lamps"][objects].astype(np.int64),
            a["doors"][objects].astype(np.int64),
            a["gesture"][objects].astype(np.int64),
            a["shown"][objects].astype(np.int64),
            tuple(a["type_id"][objects].tolist()),
        )
        light_truth = None
        if i in lit:
            k = lit[i]
            which = range(lights[k], lights[k + 1])
            parts = tuple(a["heads"][headed[j] : headed[j + 1]].astype(np.float64) for j in which)
            span = slice(lights[k], lights[k + 1])
            light_truth = LightTruth(a["light_id"][span], a["light_state"][span], parts)
        jpeg = None
        if i in drawn:
            k = drawn[i]
            jpeg = a["jpeg"][jpegs[k] : jpegs[k + 1]].tobytes()
        yield Recorded(
            time_s=float(time_s),
            pose=a["pose"][i],
            sweep=LidarSweep(float(time_s), points),
            imu=a["imu"][i],
            gnss=a["gnss"][i],
            wheel_mps=float(a["wheel_mps"][i]),
            truth=truth,
            lights=light_truth,
            jpeg=jpeg,
            instances=_mask(a[f"instances_{i}"]) if i in masked else None,
        )


def _starts(lengths: NDArray[Any]) -> list[int]:
    return [0, *np.cumsum(lengths).astype(int).tolist()]


def _png(mask: NDArray[np.uint16]) -> bytes:
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray(mask).save(file, "PNG", compress_level=1)
    return file.getvalue()


def _mask(data: NDArray[np.uint8]) -> NDArray[np.uint16]:
    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(data.tobytes()))).astype(np.uint16)
