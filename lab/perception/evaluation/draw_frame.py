"""Draws one time of a recording: the camera's picture, and from above the true objects and the results of perception.

`python -m lab.perception.evaluation.draw_frame --data RECORDING --at SECONDS --out PNG`. It requires the extras
`perception` and `report`.
"""

from __future__ import annotations

import argparse
import io
import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lab.perception.evaluation.scoring.samples import TURN_S, is_continuous, looks_of, true_pose
from stucksolver.optional_dependencies import can_plot
from stucksolver_perception.cycle_data import PerceptionInput, PerceptionResult
from stucksolver_perception.free_space import EGO_HALF_LENGTH_M
from stucksolver_perception.lidar.detector import LidarDetector
from stucksolver_perception.lidar.sweeps import SweepBuffer
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import CameraFrame, Detections, Floats, Singles
from stucksolver_perception.network_files import NetworkFileError
from stucksolver_perception.pipeline import PerceptionPipeline, missing_libraries
from stucksolver_perception.recording import KINDS, Recorded, Recording, RecordingError
from stucksolver_perception.tracking import Track, boxes_of
from stucksolver_perception.vehicle_frame import into_vehicle

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection
    from matplotlib.figure import Figure

AHEAD_M = 30.0
"""Length ahead of the vehicle's reference point in the view from above (m)."""
BACK_M = 3.0
"""Length behind it (m)."""
ASIDE_M = 10.0
"""Width to either side (m)."""
HALF_LOOK_S = 0.051
"""Half the time between two frames of perception (s); the nearest frame is drawn."""
LEAST_SCORE = 0.3
"""Least score of a detector's box that is drawn. Ours."""
HIGHEST_M = 2.5
"""Height above which all returns have the same color (m). Ours."""
OWN_WIDTH_M = 1.9
"""Width of the ego in the drawing (m)."""
APART_M = 0.62
"""Distance between two lines of text beside the view from above (m)."""
SIZE_IN = (13.0, 7.0)
"""Size of the figure (inches)."""
DPI = 110
"""Resolution of the figure."""
THIN, THICK = 0.8, 2.2
"""Widths of the detector's outlines and of tracks (pt)."""
DASHES = (0, (4, 2))
"""Dash pattern of tracks (pt)."""
TRUTH = "#7a7f88"
OF_LABEL = dict(
    zip(
        LABELS,
        ("#1f6fb2", "#6a3fa0", "#12908e", "#d6273a", "#8a5a2b", "#e07b00", "#b0158a", "#2c8a3a"),
        strict=True,
    )
)
"""Colors of the detector's labels."""


class DrawFrameError(RuntimeError):
    """A time cannot be drawn. The message has the reason and the remedy."""


@dataclass(frozen=True, eq=False)
class FrameData:
    """Recorded data of one frame, and the results of perception."""

    tick: Recorded
    after_s: float
    """Time since the recording's beginning (s)."""
    points: Singles
    """(n, 5): the detector's input: x, y, z (m) in the vehicle frame, intensity, age (s)."""
    percept: PerceptionResult
    picture: CameraFrame | None
    """The last picture until then; None without one."""


@dataclass(frozen=True)
class _Drawn:
    """An outline from above: center x, y, length, width (m), yaw (rad) in the vehicle frame, and its text."""

    box: tuple[float, float, float, float, float]
    text: str
    color: str
    width: float = 1.0
    """Width of the line (pt)."""
    dashed: bool = False


def draw_frame(folder: Path, at_s: float, out: Path) -> Path:
    """Draw the frame nearest to `at_s` (s since the recording's beginning), and return the file.

    Raises:
        RecordingError: The folder is not a recording.
        DrawFrameError: There is no such frame, the recording has gaps, or a library is missing.
        NetworkFileError: A network cannot be used.
        OSError: The file cannot be written.
    """
    if not can_plot():
        raise DrawFrameError("not installed: matplotlib. Add the extra [report] (README, Install)")
    why = missing_libraries()
    if why:
        raise DrawFrameError(why)
    moment = _moment(Recording(folder), at_s)
    found = detected(moment)
    out.parent.mkdir(parents=True, exist_ok=True)
    _save(moment, found, out)
    return out


def moments(recording: Recording) -> Iterator[FrameData]:
    """Run all of perception on a recording, ten frames per second with true poses, as for the scores.

    Raises:
        NetworkFileError: A network cannot be used.
    """
    perceiver, buffer = PerceptionPipeline(recording.rig), SweepBuffer()
    picture, begin_s = None, None
    for ticks in looks_of(recording):
        tick, new = ticks[-1], None
        begin_s = tick.time_s if begin_s is None else begin_s
        sweeps = tuple((recorded.sweep, true_pose(recorded)) for recorded in ticks)
        for sweep, pose in sweeps:
            buffer.add(sweep, pose)
        for recorded in ticks:
            rgb = recorded.picture()
            if rgb is not None:
                new = (CameraFrame(recorded.time_s, rgb), true_pose(recorded))
        picture = picture if new is None else new[0]
        pose = true_pose(tick)
        frame, frame_pose = (None, None) if new is None else new
        look = PerceptionInput(pose, sweeps, frame, frame_pose, heads={})
        yield FrameData(tick, tick.time_s - begin_s, buffer.gather(pose), perceiver.perceive(look), picture)


def _moment(recording: Recording, at_s: float) -> FrameData:
    if not recording.files:
        raise DrawFrameError(f"the recording is empty: {recording.folder}. Record it again")
    if not is_continuous(recording):
        raise DrawFrameError(f"the recording has gaps: {recording.folder}. Collect one with --every 0")
    first = next(recording.stretch(recording.files[0])).time_s
    *_, last = (tick.time_s for tick in recording.stretch(recording.files[-1]))
    if not 0.0 <= at_s <= last - first:
        raise DrawFrameError(f"--at: expected 0 to {last - first:.1f} s, got {at_s:g} ({recording.folder})")
    return next(moment for moment in moments(recording) if moment.after_s >= at_s - HALF_LOOK_S)


def detected(moment: FrameData) -> Detections:
    """Return the detector's boxes that are drawn.

    Raises:
        NetworkFileError: A network cannot be used.
    """
    found = LidarDetector().detect(moment.points, moment.tick.time_s)
    return found.part(found.score >= LEAST_SCORE)


def _save(moment: FrameData, found: Detections, out: Path) -> None:
    from matplotlib.figure import Figure
    from PIL import Image

    figure = Figure(figsize=SIZE_IN)
    _draw_picture(figure.add_axes((0.01, 0.4, 0.48, 0.54)), moment)
    above = figure.add_axes((0.57, 0.04, 0.295, 0.91))
    dots = _draw_returns(above, moment.points[moment.points[:, 4] <= TURN_S])
    _draw_boxes(above, _real(moment), _perceived(moment, found))
    bar = figure.colorbar(dots, cax=figure.add_axes((0.05, 0.14, 0.4, 0.02)), orientation="horizontal")
    bar.set_label("height of the LiDAR's returns (m)", fontsize=8)
    bar.ax.tick_params(labelsize=7)
    _explain(figure)
    drawn = io.BytesIO()
    figure.savefig(drawn, dpi=DPI)
    # With a palette, the file is a quarter as large. The octree preserves rare colors, such as those of thin lines.
    Image.open(drawn).convert("RGB").quantize(256, Image.Quantize.FASTOCTREE).save(out, "PNG", optimize=True)


def _draw_picture(axes: Axes, moment: FrameData) -> None:
    axes.set_axis_off()
    title = f"{moment.after_s:.1f} s, {abs(3.6 * float(moment.tick.pose[6])):.0f} km/h"
    if moment.picture is None:
        axes.set_title(f"{title}; no picture yet", fontsize=9, loc="left")
        return
    age_s = moment.tick.time_s - moment.picture.time_s
    older = f"; the picture is {age_s:.1f} s older" if age_s > HALF_LOOK_S else ""
    axes.set_title(title + older, fontsize=9, loc="left")
    axes.imshow(moment.picture.rgb)


def _explain(figure: Figure) -> None:
    """Write the meaning of the outlines, and the color of each label."""
    from matplotlib.lines import Line2D

    kinds = [
        Line2D([], [], color=TRUTH, lw=1.0, ls=DASHES, label="true objects"),
        Line2D([], [], color="black", lw=THIN, label="detector, score"),
        Line2D([], [], color="black", lw=THICK, label="#track, probability"),
    ]
    labels = [Line2D([], [], color=color, lw=THICK, label=label) for label, color in OF_LABEL.items()]
    for lines, top in ((kinds, 0.36), (labels, 0.31)):
        place = {"loc": "upper left", "bbox_to_anchor": (0.04, top), "ncols": 4}
        figure.legend(handles=lines, fontsize=8, frameon=False, **place)


def _draw_returns(axes: Axes, turn: Singles) -> PathCollection:
    """Draw the ego and the LiDAR's returns: x (ahead) upwards, and y (to the left) to the left."""
    axes.set_xlim(ASIDE_M, -ASIDE_M)
    axes.set_ylim(-BACK_M, AHEAD_M)
    axes.set_aspect("equal")
    axes.tick_params(labelsize=7)
    axes.set_title("from above (m)", fontsize=9)
    axes.fill(*_outline((0.0, 0.0, 2 * EGO_HALF_LENGTH_M, OWN_WIDTH_M, 0.0)), color="#c9ccd2", zorder=2)
    shown = turn[np.argsort(turn[:, 2])]
    x, y, z = shown[:, 0], shown[:, 1], shown[:, 2]
    return axes.scatter(y, x, s=1.5, c=z, vmin=0.0, vmax=HIGHEST_M, cmap="viridis_r", lw=0)


def _draw_boxes(axes: Axes, real: Sequence[_Drawn], detected_boxes: Sequence[_Drawn]) -> None:
    """Draw the outlines. The texts of true objects stand to the left of the view, those of the others to its right."""
    for drawn in (*real, *detected_boxes):
        y, x = _outline(drawn.box)
        style = DASHES if drawn.dashed else "solid"
        axes.fill(y, x, fill=False, ec=drawn.color, lw=drawn.width, ls=style, zorder=3 + drawn.width)
    _write_beside(axes, real, ASIDE_M + 1.3, "right")
    _write_beside(axes, detected_boxes, -ASIDE_M - 0.3, "left")


def _write_beside(axes: Axes, drawn: Sequence[_Drawn], y_m: float, align: str) -> None:
    """Write the text of each box at the edge, in the order of their distance, and a line from it to the box."""
    ordered = sorted(drawn, key=lambda item: item.box[0])
    for item, at_m in zip(ordered, spread([item.box[0] for item in ordered], APART_M, -BACK_M, AHEAD_M), strict=True):
        weight = "bold" if item.width == THICK else "normal"
        axes.text(y_m, at_m, item.text, color=item.color, fontsize=6.5, ha=align, va="center", weight=weight)
        edge_m = math.copysign(ASIDE_M, y_m)
        axes.plot((edge_m, item.box[1]), (at_m, item.box[0]), color=item.color, lw=0.4, alpha=0.5, zorder=2.5)


def spread(wanted: Sequence[float], apart: float, low: float, high: float) -> list[float]:
    """Return ascending values near the `wanted` ones (ascending), `apart` from each other.

    As far as they fit, they are between `low` and `high`.
    """
    placed: list[float] = []
    for value in wanted:
        placed.append(max(value, placed[-1] + apart if placed else low))
    ceiling = high
    for i in reversed(range(len(placed))):
        placed[i] = min(placed[i], ceiling)
        ceiling = placed[i] - apart
    return placed


def _real(moment: FrameData) -> list[_Drawn]:
    truth = moment.tick.truth
    boxes = into_vehicle(truth.boxes[:, [0, 1, 2, 4, 5, 6, 3]], true_pose(moment.tick))
    kinds = [KINDS[kind].value for kind in truth.kind.tolist()]
    return _in_view([_Drawn(_flat(box), kind, TRUTH, 1.0, dashed=True) for box, kind in zip(boxes, kinds, strict=True)])


def _perceived(moment: FrameData, found: Detections) -> list[_Drawn]:
    rows = np.column_stack([found.center, found.size, found.yaw])
    labels = [LABELS[label] for label in found.label.tolist()]
    thin = [
        _Drawn(_flat(row), f"{label} {score:.2f}", OF_LABEL[label], THIN)
        for row, label, score in zip(rows, labels, found.score.tolist(), strict=True)
    ]
    return _in_view([*thin, *(_track(track, moment) for track in moment.percept.tracks)])


def _track(track: Track, moment: FrameData) -> _Drawn:
    attributes = moment.percept.attributes.get(track.id)
    label = LABELS[track.label]
    kind = (
        f" ({attributes.kind.value})"
        if attributes is not None and attributes.kind is not None and attributes.kind.value != label
        else ""
    )
    text = f"#{track.id} {label}{kind} {track.confidence:.2f}{', hidden' if track.hidden else ''}"
    return _Drawn(_flat(boxes_of([track], moment.percept.pose)[0]), text, OF_LABEL[label], THICK)


def _flat(box: Floats) -> tuple[float, float, float, float, float]:
    x, y, _, length, width, _, yaw = (float(item) for item in box)
    return x, y, length, width, yaw


def _in_view(drawn: Sequence[_Drawn]) -> list[_Drawn]:
    return [item for item in drawn if -BACK_M < item.box[0] < AHEAD_M and abs(item.box[1]) < ASIDE_M]


def _outline(box: tuple[float, float, float, float, float]) -> tuple[Floats, Floats]:
    """Return the corners' y and x, as they are drawn."""
    x, y, length, width, yaw = box
    along, across = length / 2 * np.array([1, 1, -1, -1]), width / 2 * np.array([1, -1, -1, 1])
    cos, sin = math.cos(yaw), math.sin(yaw)
    return y + along * sin + across * cos, x + along * cos - across * sin


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw a frame and print the file's name; return 2 for a wrong request, else 0."""
    parser = argparse.ArgumentParser(description="Draws what perception says at one moment of a recording.")
    parser.add_argument(
        "--data", type=Path, required=True, metavar="RECORDING", help="of `perception collect --every 0`"
    )
    parser.add_argument("--at", type=float, required=True, metavar="SECONDS", help="since the recording's beginning")
    parser.add_argument("--out", type=Path, required=True, metavar="PNG", help="the file to write")
    args = parser.parse_args(arguments)
    try:
        print(draw_frame(args.data, args.at, args.out))
    except (RecordingError, DrawFrameError, NetworkFileError, OSError) as error:
        # The error is printed as one line, without a traceback.
        print(f"frame: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
