"""Road furniture and markings that the map defines: crosswalks, stop lines, stencils, signs."""

from __future__ import annotations

import math
from typing import Any
from xml.etree import ElementTree

import numpy as np

from carlette.camera.environment.road_surface import PAINT_UP_M, WHITE, upward
from carlette.camera.environment.sampled_roads import SampledRoad
from carlette.camera.models.lettering import lettering
from carlette.camera.models.mesh import Builder, Mesh, quads
from carlette.camera.models.signs import kind_of, post_sign
from carlette.camera.rendering import tags
from carlette.geometry import Floats, rotate
from carlette.opendrive.road_network import RoadNetwork
from carlette.opendrive.signals import LIGHT_TYPE, Signal

BAR_M = 0.5
"""Width of a zebra bar (m). Ours."""
BAR_GAP_M = 0.5
"""Gap between zebra bars (m). Ours."""
STOP_LINE_M = 0.4
"""Width of a stop line (m). Ours."""
BEYOND_BOX_M = 1.7
"""Distance from the middle of a trigger box to the stop line (m). Ours."""


def crosswalks(network: RoadNetwork) -> list[Mesh]:
    """Return the zebra bars of all crosswalks."""
    rings = _rings(network.map.get_crosswalks())
    return [quads(_bars(ring[:4]), WHITE, tags.ROAD_LINE) for ring in rings if len(ring) >= 4]


def stop_lines(signals: list[Signal]) -> list[Mesh]:
    """Return a line across the governed lanes of each light and sign; shark's teeth at yield signs."""
    made = []
    for signal in signals:
        half_m = signal.box.extent.x - 0.15
        center = signal.box.center
        ahead = center.y - BEYOND_BOX_M  # the frame's y points back along the lane
        if signal.type == "205":
            shapes = [
                [(x - 0.25, ahead), (x + 0.25, ahead), (x, ahead + 0.7), (x, ahead + 0.7)]
                for x in np.arange(center.x - half_m + 0.3, center.x + half_m - 0.2, 0.8)
            ]
        else:
            low, high = center.x - half_m, center.x + half_m
            shapes = [[(low, ahead), (high, ahead), (high, ahead + STOP_LINE_M), (low, ahead + STOP_LINE_M)]]
        placed = [[_in_world(signal, x, y, center.z + PAINT_UP_M) for x, y in shape] for shape in shapes]
        if placed:
            made.append(quads(upward(np.array(placed, float)), WHITE, tags.ROAD_LINE))
    return made


def signs(root: ElementTree.Element, roads: list[SampledRoad], signals: list[Signal]) -> list[tuple[Mesh, Floats]]:
    """Return sign meshes with their positions (3,)."""
    made: list[tuple[Mesh, Floats]] = []
    governed = {item.id: item for item in signals if item.type != LIGHT_TYPE}
    for element, road in zip(root.findall("road"), roads, strict=True):
        for item in [*element.iterfind("signals/signal"), *element.iterfind("objects/object")]:
            kind = kind_of(item.get("name", ""), item.get("type", ""), item.get("value", ""))
            if kind is None:
                continue
            point, yaw = _point_beside_road(road, float(item.get("s", "0")), float(item.get("t", "0")))
            signal = governed.get(item.get("id", ""))
            if signal is not None:
                yaw = math.radians(signal.pose.rotation.yaw + 90.0)
            made.append((post_sign(*kind).placed(float(point[0]), float(point[1]), float(point[2]), yaw), point))
    return made


def stencils(root: ElementTree.Element, roads: list[SampledRoad]) -> list[Mesh]:
    """Return letters, arrows and single stop lines painted on the road."""
    made = []
    for element, road in zip(root.findall("road"), roads, strict=True):
        for item in element.iterfind("objects/object"):
            builder = _stencil(item.get("name", ""))
            if builder is not None:
                s, t = float(item.get("s", "0")), float(item.get("t", "0"))
                point, yaw = _point_beside_road(road, s, t)
                placed = builder.mesh().placed(
                    float(point[0]), float(point[1]), float(point[2]) + PAINT_UP_M, yaw + math.pi
                )
                made.append(placed)
    return made


def _stencil(name: str) -> Builder | None:
    """Return a road marking for a driver who drives along +x."""
    builder = Builder(tags.ROAD_LINE)
    if name == "Stencil_STOP":
        lettering(builder, "STOP", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0), 2.4, WHITE, width_m=2.2)
        return builder
    if name.startswith("Stencil_Arrow"):
        side = -1.0 if name.endswith("L") else 1.0
        up = (0.0, 0.0, 1.0)
        builder.face([(-1.4, -0.08, 0), (0.6, -0.08, 0), (0.6, 0.08, 0), (-1.4, 0.08, 0)], WHITE, up)
        if name[-1] in "LR":
            low, high = sorted((0.08 * -side, 0.55 * side))
            builder.face([(0.5, low, 0), (0.7, low, 0), (0.7, high, 0), (0.5, high, 0)], WHITE, up)
            builder.face([(0.2, 0.55 * side, 0), (1.0, 0.55 * side, 0), (0.6, 1.15 * side, 0)], WHITE, up)
        else:
            builder.face([(0.6, -0.4, 0), (0.6, 0.4, 0), (1.5, 0.0, 0)], WHITE, up)
        return builder
    return None


def _point_beside_road(road: SampledRoad, s: float, t: float) -> tuple[Floats, float]:
    """Return a position next to a road, and the yaw (rad) that faces the traffic passing on that side."""
    at = np.array([min(max(s, 0.0), road.length)])
    point = road.points(at, np.array([t]))[0]
    heading = float(road.line(at)[2][0])
    section = next((item for item in reversed(road.sections) if item.start <= s + 1e-6), road.sections[0])
    left = any(lane.kind == "driving" for lane in section.left)
    right = any(lane.kind == "driving" for lane in section.right)
    middle = float(road.offset.value_at(at)[0])
    is_forward = right if left != right else t < middle
    return point, -heading + (math.pi if is_forward else 0.0)


def _rings(places: list[Any]) -> list[Floats]:
    """Return closed polygons from a flat list of points; each polygon ends at its first point."""
    rings: list[Floats] = []
    current: list[tuple[float, float, float]] = []
    for place in places:
        point = (place.x, place.y, place.z)
        if current and math.dist(point, current[0]) < 1e-3:
            rings.append(np.array(current))
            current = []
        else:
            current.append(point)
    return rings


def _bars(ring: Floats) -> Floats:
    """Return bars along the shorter sides of a four-cornered ring."""
    if np.linalg.norm(ring[1] - ring[0]) < np.linalg.norm(ring[2] - ring[1]):
        ring = np.roll(ring, -1, axis=0)
    a, b, c, d = ring
    long_m = float(np.linalg.norm(b - a))
    count = max(1, int((long_m + BAR_GAP_M) / (BAR_M + BAR_GAP_M)))
    starts = (
        np.arange(count) * (BAR_M + BAR_GAP_M) + 0.5 * (long_m - count * (BAR_M + BAR_GAP_M) + BAR_GAP_M)
    ) / long_m
    ends = starts + BAR_M / long_m
    edges = [
        np.outer(1 - part, item) + np.outer(part, other) for part in (starts, ends) for item, other in ((a, b), (d, c))
    ]
    bars = np.stack([edges[0], edges[2], edges[3], edges[1]], axis=1)
    bars[..., 2] += PAINT_UP_M
    return upward(bars)


def _in_world(signal: Signal, x: float, y: float, z: float) -> list[float]:
    place = signal.pose.location
    turned = rotate(type(place)(x, y, z), signal.pose.rotation)
    return [place.x + turned.x, place.y + turned.y, place.z + turned.z]
