"""The road's surface as meshes: lanes, curbs and sidewalks, and the paint along lanes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from carlette.camera.environment.sampled_roads import SampledLane, SampledMarking, SampledRoad, SampledSection
from carlette.camera.models.mesh import Color, Mesh, quads
from carlette.camera.rendering import tags
from carlette.geometry import Floats
from carlette.opendrive.road_network import CURB_M

ASPHALT: Color = (92, 93, 96)
JUNCTION: Color = (90, 91, 94)
GUTTER: Color = (112, 111, 108)
SLABS: Color = (168, 163, 154)
CURB: Color = (196, 193, 186)
VERGE: Color = (104, 128, 70)
SOIL: Color = (120, 114, 104)
CYCLEWAY: Color = (128, 84, 76)
WHITE: Color = (236, 236, 230)
YELLOW: Color = (238, 178, 28)
PAINTS = {"yellow": YELLOW, "blue": (60, 100, 200), "red": (200, 50, 40), "green": (50, 160, 70)}
PAINT_UP_M = 0.02
"""Height of paint above the road (m), so that it is drawn on top. Ours."""
CURB_TOP_M = 0.14
"""Width of the lighter line along a curb's edge (m). Ours."""
LEAST_PAINT_M = 0.15
"""Smallest width of a painted line (m), so that it is visible in a picture. Ours."""
DASH_M = 3.0
"""Length of a dash (m). Ours."""
GAP_M = 4.5
"""Gap between dashes (m). Ours."""
SKIRT_M = 1.2
"""Depth of the skirt below the outermost borders (m). Ours."""

_FLOORS: dict[str, tuple[Color, int]] = {
    "sidewalk": (SLABS, tags.SIDEWALK),
    "walking": (SLABS, tags.SIDEWALK),
    "curb": (CURB, tags.SIDEWALK),
    "shoulder": (GUTTER, tags.ROAD),
    "none": (VERGE, tags.TERRAIN),
    "median": (VERGE, tags.TERRAIN),
    "border": (GUTTER, tags.ROAD),
    "biking": (CYCLEWAY, tags.ROAD),
    "tram": (ASPHALT, tags.RAIL_TRACK),
    "rail": (ASPHALT, tags.RAIL_TRACK),
}
"""Color and tag by lane type. All others are asphalt."""
_RAISED = {"sidewalk": CURB_M, "walking": CURB_M, "median": CURB_M}


@dataclass
class Pavement:
    """The geometry that comes from a map's lanes."""

    floor: list[Mesh] = field(default_factory=list)
    paint: list[Mesh] = field(default_factory=list)
    lanes: list[Floats] = field(default_factory=list)
    """Quads of all lanes, (n, 4, 2) (m). Nothing else may be placed there."""
    driving: list[Floats] = field(default_factory=list)
    """Quads of the driving lanes."""
    junctions: dict[str, list[Floats]] = field(default_factory=dict)
    """Quads (n, 4, 3) of the lanes of each junction."""
    edges: list[tuple[SampledRoad, Floats, Floats]] = field(default_factory=list)
    """Outermost borders: road, world points (n, 3) and outward directions (n, 2), each about a step apart."""


def pave(roads: list[SampledRoad]) -> Pavement:
    """Return lanes, curbs and paint of all roads."""
    made = Pavement()
    for road in roads:
        for section in road.sections:
            s = road.stations(section.start, section.end)
            borders = road.borders(section, s)
            for lane, inner, outer in borders:
                _lane(made, road, s, (lane, inner, outer))
            _curbs(made, road, s, borders)
            _outside(made, road, s, borders)
            made.paint.extend(_markings(road, section))
    return made


def _strip(
    road: SampledRoad, s: Floats, first: Floats, second: Floats, up_m: float = 0.0, up_other_m: float = 0.0
) -> Floats:
    """Return quads (n, 4, 3) between two lines along the road, facing up."""
    a, b = road.points(s, first, up_m), road.points(s, second, up_other_m)
    strip = np.stack([a[:-1], b[:-1], b[1:], a[1:]], axis=1)
    return upward(strip)


def upward(corners: Floats) -> Floats:
    """Return the same quads, each seen from above."""
    first, last = corners[:, 2, :2] - corners[:, 0, :2], corners[:, 3, :2] - corners[:, 1, :2]
    down = first[:, 0] * last[:, 1] - first[:, 1] * last[:, 0] < 0
    corners[down] = corners[down][:, ::-1]
    return corners


def _lane(made: Pavement, road: SampledRoad, s: Floats, place: tuple[SampledLane, Floats, Floats]) -> None:
    lane, inner, outer = place
    if np.abs(outer - inner).max() < 0.01:
        return
    plain = JUNCTION if road.junction else ASPHALT
    color, tag = _FLOORS.get(lane.kind, (plain, tags.ROAD))
    if road.junction and color == GUTTER:
        color = plain  # inside junctions, a gutter would cross lanes
    up_m = _RAISED.get(lane.kind, 0.0)
    strip = _strip(road, s, inner, outer, up_m, up_m)
    made.floor.append(quads(strip, color, tag))
    made.lanes.append(strip[..., :2])
    if road.junction:
        made.junctions.setdefault(road.junction, []).append(strip)
    if (color, tag) == (plain, tags.ROAD):
        made.driving.append(strip[..., :2])


def _curbs(made: Pavement, road: SampledRoad, s: Floats, borders: list[tuple[SampledLane, Floats, Floats]]) -> None:
    """Draw the step up to each raised lane, and a lighter line along its edge."""
    for number, (lane, inner, outer) in enumerate(borders):
        up_m = _RAISED.get(lane.kind, 0.0)
        before = borders[number - 1][0] if number and (borders[number - 1][0].id > 0) == (lane.id > 0) else None
        if not up_m or np.abs(outer - inner).max() < 0.01:
            continue
        sign = 1.0 if lane.id > 0 else -1.0
        if before is not None and before.kind not in _RAISED:
            wall = _wall(road, s, inner, up_m, -sign)
            top = _strip(road, s, inner, inner + sign * CURB_TOP_M, up_m + 0.01, up_m + 0.01)
            made.floor += [quads(wall, CURB, tags.SIDEWALK), quads(top, CURB, tags.SIDEWALK)]
        after = borders[number + 1][0] if number + 1 < len(borders) else None
        if after is not None and (after.id > 0) == (lane.id > 0) and after.kind not in _RAISED:
            made.floor.append(quads(_wall(road, s, outer, up_m, sign), CURB, tags.SIDEWALK))


def _wall(road: SampledRoad, s: Floats, t: Floats, up_m: float, left: float, down_m: float = 0.0) -> Floats:
    """Return a vertical strip along the road, visible from its left (`left` = 1) or right (-1)."""
    low, high = road.points(s, t, -down_m), road.points(s, t, up_m)
    strip = np.stack([low[:-1], low[1:], high[1:], high[:-1]], axis=1)
    aside = road.points(s, t + left) - road.points(s, t)
    normal = np.cross(strip[:, 1] - strip[:, 0], strip[:, 3] - strip[:, 0])
    away = (normal * aside[:-1]).sum(axis=1) < 0
    strip[away] = strip[away][:, ::-1]
    return strip


def _outside(made: Pavement, road: SampledRoad, s: Floats, borders: list[tuple[SampledLane, Floats, Floats]]) -> None:
    """Draw a skirt below the outermost borders, down to the terrain, and store the borders for the roadside."""
    for sign in (1.0, -1.0):
        side = [border for border in borders if (border[0].id > 0) == (sign > 0)]
        lane = side[-1][0] if side else None
        t = side[-1][2] if side else road.offset.value_at(s)
        up_m = _RAISED.get(lane.kind, 0.0) if lane else 0.0
        made.floor.append(
            quads(_wall(road, s, t, up_m, sign, SKIRT_M), JUNCTION if road.junction else SOIL, tags.TERRAIN)
        )
        points, beyond = road.points(s, t), road.points(s, t + sign)
        made.edges.append((road, points, (beyond - points)[:, :2]))


def _markings(road: SampledRoad, section: SampledSection) -> Iterator[Mesh]:
    """Yield the paint of one section."""
    lines: list[tuple[list[SampledMarking], float, SampledLane | None]] = [(section.center_marks, 0.0, None)]
    lines += [(lane.marks, 1.0 if lane.id > 0 else -1.0, lane) for lane in [*section.left, *section.right]]
    for marks, sign, lane in lines:
        for number, mark in enumerate(marks):
            end = marks[number + 1].start if number + 1 < len(marks) else section.end
            start, end = max(mark.start, section.start), min(end, section.end)
            if end - start > 0.05:
                yield from _mark(road, section, lane, mark, (start, end), sign)


def _mark(
    road: SampledRoad,
    section: SampledSection,
    lane: SampledLane | None,
    mark: SampledMarking,
    reach: tuple[float, float],
    sign: float,
) -> Iterator[Mesh]:
    color = PAINTS.get(mark.color, WHITE)
    width = max(mark.width_m, LEAST_PAINT_M)
    parts = mark.kind.split()
    if not set(parts) <= {"solid", "broken"}:
        return
    up_m = PAINT_UP_M + (_RAISED.get(lane.kind, 0.0) if lane else 0.0)
    for number, part in enumerate(parts):
        # The first part of a double line is nearer to the road's left.
        shift = 0.0 if len(parts) == 1 else (0.5 - number) * 2.2 * width * (sign or 1.0)
        stretches = [reach] if part == "solid" else list(_dashes(section.start, *reach))
        strips = [_painted(road, section, lane, stretch, (shift, width), up_m) for stretch in stretches]
        if strips:
            yield quads(np.concatenate(strips), color, tags.ROAD_LINE)


def _dashes(origin: float, start: float, end: float) -> Iterator[tuple[float, float]]:
    step = DASH_M + GAP_M
    for number in range(int((start - origin) / step), int((end - origin) / step) + 1):
        low, high = max(start, origin + number * step), min(end, origin + number * step + DASH_M)
        if high - low > 0.3:
            yield low, high


def _painted(
    road: SampledRoad,
    section: SampledSection,
    lane: SampledLane | None,
    reach: tuple[float, float],
    line: tuple[float, float],
    up_m: float,
) -> Floats:
    s = road.stations(*reach)
    shift, width = line
    t = road.offset.value_at(s)
    if lane is not None:
        t = next(outer for border, _, outer in road.borders(section, s) if border.id == lane.id)
    return _strip(road, s, t + shift - width / 2, t + shift + width / 2, up_m, up_m)
