"""Reports on a log, as texts in CARLA's format."""

from __future__ import annotations

import numpy as np

from carlette.recorder.log_file import Entry, LogFile

KINDS = {"vehicle.": "v", "walker.": "w", "traffic.": "t"}


def file_info(tape: LogFile, show_all: bool) -> str:
    """Return map, date and length; with `show_all`, also each frame that contains an event."""
    lines = [_head(tape)]
    if show_all:
        known: set[int] = set()
        for frame in tape.frames:
            now = set(frame.ids.tolist())
            came, left = sorted(now - known), sorted(known - now)
            known = now
            if came or left:
                lines.append(f"Frame {frame.number} at {frame.time_s:.3f} seconds")
                lines += [f"  Create {item}: {tape.entries[item].type_id}" for item in came]
                lines += [f"  Destroy {item}" for item in left]
    return "\n".join([*lines, _foot(tape)])


def collisions(tape: LogFile, first_kind: str, second_kind: str) -> str:
    """Return collisions of two kinds: h hero, v vehicle, w walker, t traffic light, o other, a any."""
    lines = [_head(tape), f"{'Time':>8}  Types  {'Id':>6} Actor 1{'':<33} {'Id':>6} Actor 2"]
    for hit in tape.hits:
        pair = [tape.entries.get(item) for item in (hit.id, hit.other_id)]
        for item, other in (pair, pair[::-1]):
            if item and other and _is(item, first_kind) and _is(other, second_kind):
                kinds = f"{_kind(item)} {_kind(other)}"
                lines.append(
                    f"{hit.time_s:8.2f}  {kinds:5}  {item.id:>6} {item.type_id:<40} {other.id:>6} {other.type_id}"
                )
                break
    return "\n".join([*lines, _foot(tape)])


def blocked(tape: LogFile, least_s: float, least_m: float) -> str:
    """Return vehicles and walkers that moved less than `least_m` within `least_s`, longest first."""
    found = [stop for number in tape.entries for stop in _stops(tape, number, least_s, least_m)]
    found.sort(key=lambda item: -item[2])
    lines = [_head(tape), f"{'Time':>8}  {'Id':>6} Actor{'':<35} {'Duration':>10}"]
    lines += [
        f"{begin:8.2f}  {number:>6} {tape.entries[number].type_id:<40} {length:10.2f}"
        for number, begin, length in found
    ]
    return "\n".join([*lines, _foot(tape)])


def _stops(tape: LogFile, number: int, least_s: float, least_m: float) -> list[tuple[int, float, float]]:
    """Return id, start and length of each period in which an actor hardly moves."""
    if _kind(tape.entries[number]) not in ("h", "v", "w"):
        return []
    times, places = [], []
    for frame in tape.frames:
        here = np.flatnonzero(frame.ids == number)
        if len(here):
            times.append(frame.time_s)
            places.append(frame.motion[here[0], :3])
    found, begin = [], 0
    for index in range(1, len(times) + 1):
        if index == len(times) or float(np.linalg.norm(places[index] - places[begin])) >= least_m:
            if times[index - 1] - times[begin] >= least_s:
                found.append((number, times[begin], times[index - 1] - times[begin]))
            begin = index
    return found


def _head(tape: LogFile) -> str:
    return f"Version: carlette 1\nMap: {tape.map_name}\nDate: {tape.date}\n"


def _foot(tape: LogFile) -> str:
    return f"\nFrames: {len(tape.frames)}\nDuration: {tape.duration_s:g} seconds\n"


def _is(entry: Entry, kind: str) -> bool:
    return kind in ("a", _kind(entry)) or (kind == "v" and _kind(entry) == "h")


def _kind(entry: Entry) -> str:
    if entry.role == "hero":
        return "h"
    return next((letter for prefix, letter in KINDS.items() if entry.type_id.startswith(prefix)), "o")
