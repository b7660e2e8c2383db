"""Draws a record: the straightened road from above at several times. Needs matplotlib."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stucksolver.plan import Execute
from stucksolver.plan.directive import directive_adapter
from stucksolver.record.hash_chain import RecordError, read_chain
from stucksolver.record.surroundings_delta import DeltaDecoder
from stucksolver.scene import LaneDirection, ObjectKind
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.mirror import with_sides_swapped
from stucksolver.scene.wording import in_one_line
from stucksolver.solver.events import EventKind

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOMENTS = 5
"""Number of times that are drawn without a request. Ours."""
AT_ABOUT_S = 0.5
"""Time by which a requested time may be before the first recorded one, or after the last (s). Ours."""
BACK_M = 25.0
"""Length of road behind the ego in the picture (m)."""
AHEAD_M = 55.0
"""Length of road ahead of the ego in the picture (m)."""
ASIDE_M = 12.0
"""Greatest width of the lanes on either side in the picture (m)."""
BESIDE_M = 1.5
"""Width beside the lanes in the picture (m)."""
DPI = 130
COLUMNS = 150
"""Longest title (characters)."""
ROAD = "#e9eaee"
ONCOMING = "#f6e9dc"
EGO = "#1f6fb2"
OTHER = "#6b7078"
MOVING = "#c2571a"
PATH = "#2c9a4b"
TOLD = frozenset({EventKind.STARTED, EventKind.ABORTED, EventKind.FINISHED, EventKind.STOPPED, EventKind.RECOVERED})
"""Kinds of events that are shown as a title until the next one."""


@dataclass(frozen=True)
class _Moment:
    time_s: float
    view: FrenetScene
    path: tuple[tuple[float, float], ...]
    text: str


def draw_record(record: Path, picture: Path, at_s: Sequence[float] = ()) -> Path:
    """Draw the times nearest to `at_s`, or several from the first check of a plan to the last.

    Args:
        record: Record.
        picture: File to write.
        at_s: Times of the stack's clock (s).

    Raises:
        RecordError: The record cannot be read, or has no surroundings at all or at a requested time.
        OSError: The file cannot be written.
    """
    from matplotlib.figure import Figure

    moments = _read(record)
    if not moments:
        raise RecordError(f"{record}: the record contains no check of a plan, so there is nothing to draw")
    first, last = moments[0].time_s, moments[-1].time_s
    for time_s in at_s:
        if not first - AT_ABOUT_S <= time_s <= last + AT_ABOUT_S:
            raise RecordError(
                f"{record}: nothing was recorded at {time_s:g} s; choose from {first:.1f} to {last:.1f} s"
            )
    times = sorted(at_s) or list(np.linspace(first, last, MOMENTS))
    chosen = [min(moments, key=lambda m: abs(m.time_s - t)) for t in times]
    figure = Figure(figsize=(11, 1.9 * len(chosen)), layout="constrained")
    for axes, moment in zip(np.atleast_1d(figure.subplots(len(chosen), 1)), chosen, strict=True):
        _draw(axes, moment, first)
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=DPI)
    return picture


def _read(record: Path) -> list[_Moment]:
    """Return every tick with recorded surroundings."""
    reader = _RecordReader()
    for number, line in read_chain(record):
        reader.take(record, number, line)
    return reader.moments


class _RecordReader:
    """Reader that collects every tick with recorded surroundings."""

    def __init__(self) -> None:
        self.moments: list[_Moment] = []
        self._unpacker = DeltaDecoder()
        self._path: tuple[tuple[float, float], ...] = ()
        self._text = ""

    def take(self, record: Path, number: int, line: dict[str, Any]) -> None:
        try:
            if line["kind"] == "road":
                self._unpacker.add_road(line["road"])
            elif line["kind"] == "step":
                self._step(line)
        except (AttributeError, LookupError, TypeError, ValueError, ArithmeticError, RecursionError) as error:
            raise RecordError(f"{record}, line {number}: this line cannot be read: {in_one_line(error)}") from error

    def _step(self, line: dict[str, Any]) -> None:
        if "directive" in line:
            directive = directive_adapter.validate_python(line["directive"])
            self._path = tuple((p.x_m, p.y_m) for p in directive.path) if isinstance(directive, Execute) else ()
        view = FrenetScene(self._unpacker.unpack(line["seen"])) if "seen" in line else None
        for output in line.get("told", ()):
            event = output.get("event", {})
            if event and EventKind(event["kind"]) in TOLD:
                self._text = f"{event['kind']}: {event['text']}"
            if view is not None and "judged" in output:
                self.moments.append(_Moment(line["time_s"], view, (), _review_text(output["judged"])))
            elif view is not None and "tick" in output:
                self.moments.append(_Moment(line["time_s"], view, self._path, self._text))


def _review_text(data: dict[str, Any]) -> str:
    verdict = "; ".join(f"{r['code']}: {r['detail']}" for r in data["verdict"].get("rejects", ()))
    plan = ", ".join(b["name"] for b in data["plan"]["behaviors"])
    return f"{plan}: {'rejected, ' + verdict if verdict else 'accepted'}"


def _draw(axes: Axes, moment: _Moment, start_s: float) -> None:
    view = moment.view
    for lane in view.frame.lanes:
        opposite = lane.strip.direction is LaneDirection.OPPOSITE
        axes.fill_between(lane.s, lane.right, lane.left, color=ONCOMING if opposite else ROAD, lw=0)
        for border in (lane.right, lane.left):
            axes.plot(lane.s, border, color="white", lw=1, zorder=1)
    if moment.path:
        s, d, _ = view.frame.to_road(np.array(moment.path))
        axes.plot(s, d, color=PATH, lw=1.5, zorder=4)
    for i, obj in enumerate(view.objects):
        pose = (view.s[i], view.d[i], view.yaw[i])
        color = MOVING if view.moving[i] else OTHER
        _box(axes, pose, (view.half_length[i], view.half_width[i]), color)
        if abs(view.s[i] - view.ego_s) < AHEAD_M and obj.kind is not ObjectKind.CONE:
            speed = f" {3.6 * view.speed[i]:.0f} km/h" if view.moving[i] else ""
            axes.text(
                view.s[i], view.d[i], obj.id + speed, fontsize=6, ha="center", va="center", clip_on=True, zorder=5
            )
    ego = view.ego
    _box(axes, (view.ego_s, view.ego_d, view.ego_yaw), (ego.length_m / 2, ego.width_m / 2), EGO)
    axes.set_xlim(view.ego_s - BACK_M, view.ego_s + AHEAD_M)
    visible = [
        lane for lane in view.frame.lanes if lane.start_m < view.ego_s + AHEAD_M and lane.end_m > view.ego_s - BACK_M
    ]
    axes.set_ylim(
        max(min((float(lane.right.min()) for lane in visible), default=0.0) - BESIDE_M, -ASIDE_M),
        min(max((float(lane.left.max()) for lane in visible), default=0.0) + BESIDE_M, ASIDE_M),
    )
    axes.set_aspect("equal")
    axes.set_xticks([])
    axes.set_yticks([])
    text = moment.text
    if view.surroundings.road.mirrored:
        axes.invert_yaxis()
        text = with_sides_swapped(text)
    title = f"{moment.time_s - start_s:.1f} s, {3.6 * ego.speed_mps:.0f} km/h: {text}"
    axes.set_title(textwrap.shorten(title, COLUMNS), fontsize=8, loc="left")


def _box(axes: Axes, pose: tuple[float, float, float], half: tuple[float, float], color: str) -> None:
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    along, across = half[0] * np.array([1, 1, -1, -1]), half[1] * np.array([1, -1, -1, 1])
    axes.fill(pose[0] + along * cos - across * sin, pose[1] + along * sin + across * cos, color=color, lw=0, zorder=3)
