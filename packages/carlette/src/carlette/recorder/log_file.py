"""The log file: a line that names the format, then msgpack arrays that each begin with their kind.

```
["start", map, date]                                    once
["spawn", id, type, {attribute: [type, text]}, parent]  at the first frame of an actor
["gone", id]
["hit", seconds, id, other id, impulse in N·s]
["frame", number, seconds, ids, motion, light ids, light colors]
```

`ids` are packed uint32. `motion` is packed float32: x y z, pitch yaw roll, vx vy vz of each actor. If a file ends in
the middle of an array (its disk was full, or its server was killed), the part before it is read.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import msgpack
import numpy as np
from numpy.typing import NDArray

from carlette.errors import RequestError
from carlette.geometry import FARTHEST
from carlette.safe_files import read_regular

MAGIC = b"carlette log 1\n"
NUMBERS = 9
"""Numbers per actor in `motion`."""
LARGEST_BYTES = 1 << 31
"""Largest log that is read (bytes). Ours."""


class Entry(NamedTuple):
    """An actor that appears in the log."""

    id: int
    type_id: str
    attributes: dict[str, tuple[int, str]]
    parent_id: int

    @property
    def role(self) -> str:
        """Role name from the client that spawned the actor."""
        return self.attributes.get("role_name", (0, ""))[1]


class LogFrame(NamedTuple):
    """The positions of all actors in one frame."""

    number: int
    time_s: float
    """Time since the recording began (s)."""
    ids: NDArray[np.uint32]
    motion: NDArray[np.float32]
    """(n, 9)"""
    light_ids: NDArray[np.uint32]
    light_colors: NDArray[np.uint8]


class LogCollision(NamedTuple):
    """A collision."""

    time_s: float
    id: int
    other_id: int
    impulse_ns: float


@dataclass
class LogFile:
    """Content of a log."""

    path: Path
    map_name: str = ""
    date: str = ""
    entries: dict[int, Entry] = field(default_factory=dict)
    frames: list[LogFrame] = field(default_factory=list)
    hits: list[LogCollision] = field(default_factory=list)

    @property
    def duration_s(self) -> float:
        """Time from the first to the last frame (s)."""
        return self.frames[-1].time_s if self.frames else 0.0


def encode_entry(*parts: Any) -> bytes:
    """Return one array of the file."""
    packed: bytes = msgpack.packb(parts, unicode_errors="surrogateescape")
    return packed


def read_tape(path: Path) -> LogFile:
    """Read a log; raise `RequestError` if the file is missing, unreadable or of another format."""
    try:
        if not path.is_file():
            raise FileNotFoundError
        data = read_regular(path, LARGEST_BYTES)
    except FileNotFoundError:
        raise RequestError(f"File '{path}' not found on server") from None
    except OSError as error:
        raise RequestError(f"the log '{path}' cannot be read: {error.strerror}") from None
    if not data.startswith(MAGIC):
        raise RequestError(f"'{path}' is not a carlette log (CARLA's own logs cannot be read); record one with it")
    tape = LogFile(path)
    parts = msgpack.Unpacker(raw=False, unicode_errors="surrogateescape", max_buffer_size=LARGEST_BYTES)
    parts.feed(data[len(MAGIC) :])
    try:
        for part in parts:
            _take(tape, *part)
    except (msgpack.UnpackException, ValueError, TypeError, KeyError, AttributeError, IndexError) as error:
        raise RequestError(
            f"the log '{path}' is damaged after {tape.duration_s:.2f} s ({error}); record again"
        ) from None
    return tape


def _check(tape: LogFile, frame: LogFrame) -> None:
    """Raise `ValueError` for a frame that cannot be replayed."""
    if len(frame.ids) != len(frame.motion) or len(frame.light_ids) != len(frame.light_colors):
        raise ValueError("a frame has different numbers of actors and of motions")
    if not math.isfinite(frame.time_s) or not (np.abs(frame.motion) < FARTHEST).all():
        raise ValueError("a frame has a number that is not finite or too large")
    if not (tape.entries.keys() >= set(frame.ids.tolist())):
        raise ValueError("a frame has an actor that was never seen")


def _take(tape: LogFile, kind: str, *values: Any) -> None:
    if kind == "start":
        tape.map_name, tape.date = values
    elif kind == "spawn":
        number, type_id, attributes, parent_id = values
        typed = {name: (int(of), str(text)) for name, (of, text) in attributes.items()}
        tape.entries[number] = Entry(number, type_id, typed, parent_id)
    elif kind == "hit":
        tape.hits.append(LogCollision(*values))
    elif kind == "frame":
        number, time_s, ids, motion, light_ids, colors = values
        frame = LogFrame(
            number,
            time_s,
            np.frombuffer(ids, np.uint32),
            np.frombuffer(motion, np.float32).reshape(-1, NUMBERS),
            np.frombuffer(light_ids, np.uint32),
            np.frombuffer(colors, np.uint8),
        )
        _check(tape, frame)
        tape.frames.append(frame)
