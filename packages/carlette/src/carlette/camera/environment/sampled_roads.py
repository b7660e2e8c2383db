"""Roads from OpenDRIVE, sampled: reference line, heights, and the borders of each lane.

Frame: CARLA's world (y is minus OpenDRIVE's). Formulas: ASAM OpenDRIVE 1.4 to 1.8, "Geometry" and "Lanes".
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from xml.etree import ElementTree

import numpy as np

from carlette.geometry import Floats
from carlette.opendrive.document import id_as_read, number_as_read

LONGEST_STEP_M = 8.0
"""Longest quad of a straight, flat road (m). Ours."""
HILLY_STEP_M = 4.0
"""Longest quad of a road with slopes (m). Ours."""
CHORD_ERROR_M = 0.03
"""Largest deviation of a quad from a bend (m). Ours."""
_SPIRAL_STEP_M = 0.25
"""Step of the integration of a clothoid (m). Ours."""


@dataclass(frozen=True)
class Cubic:
    """A piecewise cubic a + b ds + c ds² + d ds³; ds counts from the start of each piece."""

    starts: Floats
    rows: Floats
    """(n, 4)"""

    def value_at(self, s: Floats) -> Floats:
        """Return the value at each `s`; zero if there are no pieces."""
        if not len(self.starts):
            return np.zeros_like(s)
        index = np.maximum(self.starts.searchsorted(s + 1e-9, side="right") - 1, 0)
        ds = s - self.starts[index]
        a, b, c, d = self.rows[index].T
        value: Floats = a + ds * (b + ds * (c + ds * d))
        return value

    @property
    def is_flat(self) -> bool:
        """True if it is constant."""
        return bool((self.rows[:, 1:] == 0).all())


@dataclass(frozen=True)
class SampledMarking:
    """A marking at a lane's outer border, from `start` (m along the road) on."""

    start: float
    kind: str
    color: str
    width_m: float


@dataclass(frozen=True)
class SampledLane:
    """One lane of a section."""

    id: int
    kind: str
    width: Cubic
    marks: list[SampledMarking]


@dataclass(frozen=True)
class SampledSection:
    """A stretch of road with the same lanes. `lanes` from the center outward, left ones (positive ids) first."""

    start: float
    end: float
    left: list[SampledLane]
    right: list[SampledLane]
    center_marks: list[SampledMarking]


@dataclass
class SampledRoad:
    """One road."""

    id: int
    junction: str
    """Id of its junction; empty outside of junctions."""
    length: float
    kind: str
    pieces: list[tuple[float, float, float, float, float, str, tuple[float, ...]]]
    """s, x, y, heading, length, kind and parameters of each piece of the reference line."""
    elevation: Cubic
    offset: Cubic
    sections: list[SampledSection] = field(default_factory=list)

    def line(self, s: Floats) -> tuple[Floats, Floats, Floats]:
        """Return x, y (OpenDRIVE's) and heading of the reference line."""
        x, y, heading = (np.empty_like(s) for _ in range(3))
        starts = np.array([piece[0] for piece in self.pieces])
        index = np.maximum(starts.searchsorted(s + 1e-9, side="right") - 1, 0)
        for number in set(index.tolist()):
            here = index == number
            x[here], y[here], heading[here] = _piece_at(self.pieces[number], s[here])
        return x, y, heading

    def points(self, s: Floats, t: Floats, up_m: float = 0.0) -> Floats:
        """Return world points (n, 3) at `s` along and `t` to the left of the reference line."""
        x, y, heading = self.line(s)
        return np.stack(
            [x - t * np.sin(heading), -(y + t * np.cos(heading)), self.elevation.value_at(s) + up_m], axis=1
        )

    def stations(self, start: float, end: float) -> Floats:
        """Return the positions between `start` and `end` (m) at which to cut the road into straight quads."""
        cuts = {start, end}
        for s, _, _, _, length, kind, values in self.pieces:
            low, high = max(start, s), min(end, s + length)
            if high - low > 1e-3:
                step = LONGEST_STEP_M if self.elevation.is_flat else HILLY_STEP_M
                if kind != "line":
                    bend = max(abs(values[0]), abs(values[-1])) if kind in ("arc", "spiral") else 0.1
                    step = min(step, max(1.0, math.sqrt(8 * CHORD_ERROR_M / max(bend, 1e-6))))
                cuts.update(np.linspace(low, high, max(2, math.ceil((high - low) / step) + 1)).tolist())
        ordered = sorted(cuts)
        return np.array([item for i, item in enumerate(ordered) if i == 0 or item - ordered[i - 1] > 1e-3])

    def borders(self, section: SampledSection, s: Floats) -> list[tuple[SampledLane, Floats, Floats]]:
        """Return each lane with the offsets t of its inner and outer border at each `s` (m)."""
        found = []
        for lanes, sign in ((section.left, 1.0), (section.right, -1.0)):
            inner = self.offset.value_at(s)
            for lane in lanes:
                outer = inner + sign * lane.width.value_at(s - section.start)
                found.append((lane, inner, outer))
                inner = outer
        return found


def read_roads(root: ElementTree.Element) -> list[SampledRoad]:
    """Return all roads of a document."""
    return [_read_road(item) for item in root.findall("road")]


def _read_road(element: ElementTree.Element) -> SampledRoad:
    length = float(element.get("length", "0"))
    kind = element.find("type")
    lanes = element.find("lanes")
    junction = element.get("junction", "-1").strip()
    road = SampledRoad(
        id_as_read(element.get("id")),
        "" if junction == "-1" else junction,
        length,
        kind.get("type", "town") if kind is not None else "town",
        [_read_piece(item) for item in element.findall("planView/geometry")],
        _cubic(element.findall("elevationProfile/elevation"), "s"),
        _cubic(lanes.findall("laneOffset") if lanes is not None else [], "s"),
    )
    sections = lanes.findall("laneSection") if lanes is not None else []
    starts = [float(section.get("s", "0")) for section in sections] + [length]
    for number, section in enumerate(sections):
        if starts[number + 1] - starts[number] > 1e-3:
            road.sections.append(_read_section(section, starts[number], starts[number + 1]))
    return road


def _read_section(element: ElementTree.Element, start: float, end: float) -> SampledSection:
    def read_side(name: str) -> list[SampledLane]:
        found = [_read_lane(item, start) for item in element.findall(f"{name}/lane")]
        return sorted(found, key=lambda item: abs(item.id))

    center = element.find("center/lane")
    return SampledSection(
        start, end, read_side("left"), read_side("right"), _marks(center, start) if center is not None else []
    )


def _read_lane(element: ElementTree.Element, start: float) -> SampledLane:
    width = _cubic(element.findall("width"), "sOffset")
    return SampledLane(number_as_read(element.get("id")), element.get("type", "none"), width, _marks(element, start))


def _marks(lane: ElementTree.Element, start: float) -> list[SampledMarking]:
    return [
        SampledMarking(
            start + float(item.get("sOffset", "0")),
            item.get("type", "none"),
            item.get("color", "standard"),
            float(item.get("width", "0.125")),
        )
        for item in lane.findall("roadMark")
    ]


def _cubic(elements: list[ElementTree.Element], key: str) -> Cubic:
    rows = sorted([float(element.get(name, "0")) for name in (key, "a", "b", "c", "d")] for element in elements)
    table = np.array(rows, float).reshape(-1, 5)
    return Cubic(table[:, 0], table[:, 1:])


def _read_piece(
    element: ElementTree.Element,
) -> tuple[float, float, float, float, float, str, tuple[float, ...]]:
    s, x, y, heading, length = (float(element.get(name, "0")) for name in ("s", "x", "y", "hdg", "length"))
    shape = element[0]
    names = {
        "arc": ("curvature",),
        "spiral": ("curvStart", "curvEnd"),
        "poly3": ("a", "b", "c", "d"),
        "paramPoly3": ("aU", "bU", "cU", "dU", "aV", "bV", "cV", "dV"),
    }.get(shape.tag, ())
    values = tuple(float(shape.get(name, "0")) for name in names)
    if shape.tag == "paramPoly3":
        values = (*values, 1.0 / max(length, 1e-9) if shape.get("pRange") == "normalized" else 1.0)
    return s, x, y, heading, length, shape.tag, values


def _piece_at(
    piece: tuple[float, float, float, float, float, str, tuple[float, ...]], s: Floats
) -> tuple[Floats, Floats, Floats]:
    start, x0, y0, heading, length, kind, values = piece
    u, v, turn = _local(kind, values, s - start, length)
    cos, sin = math.cos(heading), math.sin(heading)
    return x0 + u * cos - v * sin, y0 + u * sin + v * cos, heading + turn


def _local(kind: str, values: tuple[float, ...], ds: Floats, length: float) -> tuple[Floats, Floats, Floats]:
    """Return position ahead (m), to the left (m) and heading (rad) in the frame of the piece's start."""
    if kind == "arc" and abs(values[0]) > 1e-9:
        turn = ds * values[0]
        return np.sin(turn) / values[0], (1.0 - np.cos(turn)) / values[0], turn
    if kind == "spiral":
        return _spiral(values[0], (values[1] - values[0]) / max(length, 1e-9), ds)
    if kind == "poly3":
        a, b, c, d = values
        return ds, a + ds * (b + ds * (c + ds * d)), np.arctan(b + ds * (2 * c + ds * 3 * d))
    if kind == "paramPoly3":
        p = ds * values[8]
        u, v = (values[i] + p * (values[i + 1] + p * (values[i + 2] + p * values[i + 3])) for i in (0, 4))
        du, dv = (values[i + 1] + p * (2 * values[i + 2] + p * 3 * values[i + 3]) for i in (0, 4))
        return u, v, np.arctan2(dv, du)
    return ds, np.zeros_like(ds), np.zeros_like(ds)


def _spiral(curvature: float, change: float, ds: Floats) -> tuple[Floats, Floats, Floats]:
    """Return a clothoid, by Simpson's rule on short steps."""
    end = float(ds.max(initial=0.0))
    count = max(2, math.ceil(end / _SPIRAL_STEP_M))
    grid = np.linspace(0.0, end, 2 * count + 1)
    turn = grid * (curvature + 0.5 * change * grid)
    ways = []
    for values in (np.cos(turn), np.sin(turn)):
        steps = (values[0:-2:2] + 4 * values[1:-1:2] + values[2::2]) * (grid[2] - grid[0]) / 6
        ways.append(np.interp(ds, grid[::2], np.concatenate([[0.0], np.cumsum(steps)])))
    return ways[0], ways[1], ds * (curvature + 0.5 * change * ds)
