"""The road along a route is the map's own: lanes where its waypoints are, lines as they are painted."""

from __future__ import annotations

import math

import numpy as np
import pytest

carla = pytest.importorskip("carla")

import shapely  # noqa: E402
from towns import TOWNS, demo_road, route, some_roads, some_routes, town  # noqa: E402

from stucksolver.scene import LaneDirection, LaneKind, LineKind, ZoneKind  # noqa: E402
from stucksolver.scene.frenet import RoadFrame  # noqa: E402
from stucksolver_carla.stack.adjacent_lanes import line_kind  # noqa: E402
from stucksolver_carla.stack.carla_frames import to_local, to_world  # noqa: E402
from stucksolver_carla.stack.route_road import BEHIND_M, RouteRoad  # noqa: E402

STREET = ((11, -1, 5.0), (13, -1, 200.0))
AVENUE_INNER = ((3, -1, 20.0), (3, -1, 400.0))
AVENUE_OUTER = ((3, -2, 20.0), (3, -2, 400.0))
RING_CORNER = ((3, -1, 300.0), (4, -1, 60.0))
THROUGH_JUNCTION = ((1, 1, 60.0), (21, -1, 60.0))
TURN_RIGHT, TURN_LEFT = ((11, 1, 60.0), (1, -1, 60.0)), ((11, 1, 60.0), (21, -1, 60.0))
TYPES = {
    LaneKind.DRIVING: (carla.LaneType.Driving, carla.LaneType.Bidirectional),
    LaneKind.BIKING: (carla.LaneType.Biking,),
    LaneKind.PARKING: (carla.LaneType.Parking,),
    LaneKind.SHOULDER: (carla.LaneType.Shoulder,),
    LaneKind.SIDEWALK: (carla.LaneType.Sidewalk,),
}


def lanes_at(road: RouteRoad, arc_m: float) -> list[tuple]:
    """(offset, kind, direction, line) from right to left at an arc length."""
    geometry = road.slice(arc_m, None)
    k = int(np.argmin(np.abs(RoadFrame(geometry).s - arc_m)))
    here = [s for s in geometry.lanes if s.start <= k < s.start + len(s.offset_m)]
    found = [(s.offset_m[k - s.start], s.kind.value, s.direction.value, s.line[k - s.start].value) for s in here]
    return [(round(offset, 1), *rest) for offset, *rest in sorted(found)]


@pytest.mark.integration
def test_street_oncoming_lane_is_left_behind_broken_line():
    assert lanes_at(demo_road(*STREET), 200.0) == [
        (-3.5, "sidewalk", "same", "kerb"),
        (-2.0, "shoulder", "same", "none"),
        (0.0, "driving", "same", "none"),
        (3.5, "driving", "opposite", "broken"),
        (5.5, "shoulder", "opposite", "none"),
        (7.0, "sidewalk", "opposite", "kerb"),
    ]


def test_avenue_double_line_is_solid_and_adjacent_lane_same():
    """On the avenue the double line is solid, and the adjacent lane has the ego's direction."""
    inner = [lane for lane in lanes_at(demo_road(*AVENUE_INNER), 200.0) if lane[1] == "driving"]
    assert inner == [
        (-3.5, "driving", "same", "broken"),
        (0.0, "driving", "same", "none"),
        (3.5, "driving", "opposite", "solid"),
        (7.0, "driving", "opposite", "broken"),
    ]
    outer = [lane for lane in lanes_at(demo_road(*AVENUE_OUTER), 200.0) if lane[1] == "driving"]
    assert outer == [
        (0.0, "driving", "same", "none"),
        (3.5, "driving", "same", "broken"),
        (7.0, "driving", "opposite", "solid"),
        (10.5, "driving", "opposite", "broken"),
    ]


@pytest.mark.integration
@pytest.mark.parametrize("name", TOWNS)
def test_road_reference_follows_waypoints_within_5_cm(name):
    """Arc lengths grow, and the reference line follows the waypoints within 5 cm."""
    for road, way in zip(some_roads(name), some_routes(name), strict=True):
        steps = np.diff(road.arc)
        assert (steps > 1.0).all() and (steps < 2.01).all()
        assert 0.0 <= road.start_arc < road.destination_arc <= road.arc[-1]
        reference = road.slice(road.start_arc + BEHIND_M, None).reference[3:60]
        waypoints = shapely.MultiPoint([to_local(p.waypoint.transform.location) for p in way])
        line = shapely.LineString(waypoints.geoms)
        assert max(line.distance(shapely.Point(*place)) for place in reference) < 0.05
        # Its chords of 2 m cut the corner of the tightest turns, which have a radius of less than 4 m.
        met = shapely.intersection(waypoints, shapely.LineString(reference).buffer(0.2))
        assert len(met.geoms) > 100


def _changes_lanes(road: RouteRoad) -> bool:
    def lane(waypoint):
        return waypoint.road_id, waypoint.section_id, waypoint.lane_id

    pairs = [(lane(a.waypoint), lane(b.waypoint)) for a, b in zip(road.stations, road.stations[1:], strict=False)]
    return any(a[:2] == b[:2] and a[2] != b[2] for a, b in pairs)


@pytest.mark.integration
@pytest.mark.parametrize("name", TOWNS)
def test_road_own_lane_has_zero_offset_over_whole_slice(name):
    for road in some_roads(name):
        geometry = road.slice(road.start_arc + 60.0, 10.0)
        own = [s for s in geometry.lanes if s.id.startswith("own")]
        assert sum(len(s.offset_m) for s in own) == len(geometry.reference)
        assert all(offset == 0.0 for s in own for offset in s.offset_m)
        assert all(s.direction is LaneDirection.SAME and s.speed_limit_mps == 10.0 for s in own)


@pytest.mark.integration
@pytest.mark.parametrize("name", TOWNS)
def test_road_lanes_match_map_in_bends(name):
    """Every lane lies where the map has it, also in bends."""
    town_map, checked, bent = town(name), 0, 0
    for road in some_roads(name):
        if _changes_lanes(road):
            continue
        geometry = road.slice(road.start_arc + 100.0, None)
        frame = RoadFrame(geometry)
        curved = np.abs(np.gradient(frame.headings)) > 0.01
        for lane in frame.lanes:
            inside = slice(1, len(lane.s) - 1)
            x, y, heading = frame.to_local(lane.s[inside], lane.center[inside])
            for i in range(0, len(x), 3):
                height = road.stations[int(lane.s[i] / 2)].waypoint.transform.location.z
                distance, turn = _off_the_map(town_map, lane.strip, x[i], y[i], heading[i], height)
                assert distance < 0.3 and abs(turn) < 0.3, (lane.strip.id, x[i], y[i], distance, turn)
                checked += 1
                bent += bool(curved[lane.strip.start + i])
    assert checked > 200
    assert bent > 10


def _off_the_map(town_map, strip, x: float, y: float, heading: float, z: float = 0.0) -> tuple[float, float]:
    """(offset from the center of the map's lane of the strip's kind, difference in heading); inf, 0 far from any."""
    place = carla.Location(*to_world(float(x), float(y)), z)
    found = []
    for kind in TYPES[strip.kind]:
        waypoint = town_map.get_waypoint(place, project_to_road=True, lane_type=kind)
        if waypoint is not None:
            where, yaw = to_local(waypoint.transform.location), -math.radians(waypoint.transform.rotation.yaw)
            against = math.pi if strip.direction is LaneDirection.OPPOSITE else 0.0
            turn = math.remainder(yaw - float(heading) - against, math.tau)
            # Where a lane ends the map's nearest place is its end: that is a step along the lane, not off it.
            dx, dy = x - where[0], y - where[1]
            if math.hypot(dx, dy) < 2.0:
                found.append((abs(dy * math.cos(yaw) - dx * math.sin(yaw)), turn))
    return min(found, default=(math.inf, 0.0))


def test_road_lanes_match_map_in_ring_corner():
    town_map, frame = town("demo_town"), RoadFrame(demo_road(*RING_CORNER).slice(260.0, None))
    assert float(np.ptp(frame.headings)) > math.radians(60)
    for lane in frame.lanes:
        x, y, heading = frame.to_local(lane.s, lane.center)
        for i in range(len(x)):
            distance, turn = _off_the_map(town_map, lane.strip, x[i], y[i], heading[i])
            assert distance < 0.1 and abs(turn) < 0.15


@pytest.mark.parametrize("name", TOWNS)
def test_a_place_has_the_same_arc_length_whatever_the_slice(name):
    for road in some_roads(name):
        place = road.stations[int((road.start_arc + 100.0) / 2)]
        met = []
        for arc in (road.start_arc + 60.0, road.start_arc + 100.0, road.start_arc + 140.0):
            frame = RoadFrame(road.slice(arc, None))
            k = np.flatnonzero(np.hypot(frame.points[:, 0] - place.x, frame.points[:, 1] - place.y) < 0.01)
            met += [float(frame.s[i]) for i in k]
        assert len(met) >= 3
        expected = road.arc_of(place.x, place.y, int((road.start_arc + 90) / 2), int((road.start_arc + 110) / 2))
        assert min(abs(s - expected) for s in met) < 0.01
        assert sorted(met)[1] - min(met) < 0.01 or len(met) > 3


def test_slices_agree_on_lanes_zones_and_destination():
    road = demo_road(*THROUGH_JUNCTION)
    early, late = road.slice(140.0, None), road.slice(190.0, None)
    assert {z for z in early.zones if z.start_m > late.route_start_m} == {
        z for z in late.zones if z.start_m > late.route_start_m
    }
    assert early.destination_m == late.destination_m == pytest.approx(road.destination_arc)
    for arc in (170.0, 240.0):
        assert _lane_names(early, arc) == _lane_names(late, arc)
    assert early.key != late.key


def _lane_names(geometry, arc: float) -> list[str]:
    frame = RoadFrame(geometry)
    return sorted(lane.strip.id.split("@")[0] for lane in frame.lanes if lane.start_m <= arc <= lane.end_m)


def test_road_slice_before_destination_has_no_destination():
    """The destination lies beyond a slice that does not reach it."""
    way = demo_road(*STREET)
    assert way.slice(way.start_arc, None).destination_m is None
    assert way.slice(way.destination_arc, None).destination_m == pytest.approx(way.destination_arc)


@pytest.mark.parametrize("ends", [THROUGH_JUNCTION, TURN_RIGHT, TURN_LEFT])
def test_road_junction_zone_has_only_own_lane(ends):
    road = demo_road(*ends)
    geometry = road.slice(160.0, None)
    (zone,) = [z for z in geometry.zones if z.kind is ZoneKind.JUNCTION]
    frame = RoadFrame(geometry)
    town_map = town("demo_town")
    for s, (x, y) in zip(frame.s, geometry.reference, strict=True):
        inside = town_map.get_waypoint(carla.Location(*to_world(x, y))).is_junction
        if zone.start_m + 2.0 <= s <= zone.end_m - 2.0:
            assert inside
            assert _lane_names(geometry, float(s)) == ["own"]
        elif s < zone.start_m - 2.0 or s > zone.end_m + 2.0:
            assert not inside


@pytest.mark.parametrize("ends", [THROUGH_JUNCTION, TURN_RIGHT, TURN_LEFT, ((1, 2, 60.0), (21, -2, 60.0))])
def test_road_crosswalk_zones_match_map_outlines(ends):
    """Every crosswalk under the path is a zone, and no other place is."""
    road = demo_road(*ends)
    zones = [z for z in road.slice(180.0, None).zones if z.kind is ZoneKind.CROSSWALK]
    assert len(zones) == 2
    areas = [shapely.Polygon(p) for p in _outlines(town("demo_town"))]
    for station, arc in zip(road.stations, road.arc, strict=True):
        on_one = any(area.contains(shapely.Point(station.x, station.y)) for area in areas)
        in_zone = any(z.start_m <= arc <= z.end_m for z in zones)
        assert in_zone or not on_one
    for zone in zones:
        assert 3.0 <= zone.end_m - zone.start_m <= 6.0


def _outlines(town_map) -> list[list[tuple[float, float]]]:
    places = [to_local(crosswalk) for crosswalk in town_map.get_crosswalks()]
    return [places[i : i + 5] for i in range(0, len(places), 5)]


def test_the_road_goes_on_past_the_destination():
    road = demo_road(*AVENUE_INNER)
    assert road.arc[-1] - road.destination_arc == pytest.approx(80.0, abs=2.5)


def test_road_crossing_needs_route_lane_and_direction():
    """A stop line counts only on the lane of the route and in its direction."""
    road, town_map = demo_road(*AVENUE_INNER), town("demo_town")

    def crossing(lane: int) -> float | None:
        return road.crossing(town_map.get_waypoint_xodr(3, lane, 200.0).transform)

    assert crossing(-1) == pytest.approx(road.start_arc + 180.0, abs=0.2)
    assert crossing(-2) is None
    assert crossing(1) is None


def test_route_starting_at_begin_of_lane_is_read():
    town_map = town("demo_town")
    road = RouteRoad(town_map, route(town_map, (11, -1, 0.5), (11, -1, 30.0)))
    assert road.destination_arc - road.start_arc == pytest.approx(29.5, abs=1.5)


class Marking:
    def __init__(self, name: str) -> None:
        self.type = getattr(carla.LaneMarkingType, name)


@pytest.mark.parametrize(
    ("marking", "into", "expected"),
    [
        ("Broken", LaneKind.DRIVING, LineKind.BROKEN),
        ("BrokenBroken", LaneKind.DRIVING, LineKind.BROKEN),
        ("BottsDots", LaneKind.DRIVING, LineKind.BROKEN),
        ("BrokenSolid", LaneKind.DRIVING, LineKind.BROKEN),
        ("SolidBroken", LaneKind.DRIVING, LineKind.SOLID),
        ("Solid", LaneKind.DRIVING, LineKind.SOLID),
        ("SolidSolid", LaneKind.SHOULDER, LineKind.SOLID),
        ("NONE", LaneKind.DRIVING, LineKind.NONE),
        ("Curb", LaneKind.SHOULDER, LineKind.KERB),
        ("Grass", LaneKind.SHOULDER, LineKind.KERB),
        ("Broken", LaneKind.SIDEWALK, LineKind.KERB),
    ],
)
def test_a_marking_binds_as_seen_from_the_route_s_side(marking, into, expected):
    assert line_kind(Marking(marking), into) is expected


def test_line_kind_without_marking_is_none_or_kerb_at_sidewalk():
    """Where there is no marking, there is no line, but a curb at a sidewalk."""
    assert line_kind(None, LaneKind.DRIVING) is LineKind.NONE
    assert line_kind(None, LaneKind.SIDEWALK) is LineKind.KERB
