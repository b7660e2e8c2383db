"""Road coordinates: there and back again, lanes, borders, and one tick's view."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from shapely import affinity
from shapely.geometry import box

from stucksolver.scene import LaneDirection, LaneKind, LineKind, ObjectKind
from stucksolver.scene.boxes import separation
from stucksolver.scene.frenet import RoadFrame, road_frame, wrap_angle
from stucksolver.scene.wording import stood_too_briefly, whereabouts
from worlds import LANE_M, World, bent_road, straight_road, strip, thing

offsets = st.floats(-6.0, 6.0)


@given(s=st.floats(-20.0, 430.0), d=offsets)
def test_frame_straight_road_round_trip_is_exact(s, d):
    """The round trip to road coordinates is exact on a straight road, even beyond its ends."""
    frame = road_frame(straight_road())
    x, y, heading = frame.to_local(np.array([s]), np.array([d]))
    again_s, again_d, again_heading = frame.to_road(np.stack([x, y], axis=1))
    assert (again_s[0], again_d[0]) == pytest.approx((s, d), abs=1e-6)
    assert heading[0] == again_heading[0] == 0.0


@pytest.mark.integration
@given(radius=st.floats(12.0, 300.0), left=st.booleans(), s=st.floats(1.0, 18.0), d=offsets)
def test_frame_bend_round_trip_error_is_within_chord_bound(radius, left, s, d):
    """The round trip in a bend is accurate to what the chords of the road allow."""
    frame = RoadFrame(bent_road(radius if left else -radius, count=20))
    x, y, _ = frame.to_local(np.array([s]), np.array([d]))
    again_s, again_d, _ = frame.to_road(np.stack([x, y], axis=1))
    # A chord of 1 m is turned by at most half of 1 m / radius from the arc's tangent; d carries that along the road.
    slack = (abs(d) + 0.5) * 0.6 / radius + 1e-6
    assert abs(again_s[0] - s) <= slack
    assert abs(again_d[0] - d) <= slack


@given(radius=st.floats(10.0, 100.0), left=st.booleans(), s=st.floats(1.0, 17.0))
def test_the_heading_along_a_bend_is_that_of_the_arc(radius, left, s):
    radius = radius if left else -radius
    _, _, heading = RoadFrame(bent_road(radius, count=20)).to_local(np.array([s]), np.zeros(1))
    assert heading[0] == pytest.approx(s / radius, abs=0.1 / abs(radius))


@pytest.mark.integration
@given(radius=st.floats(15.0, 100.0), s=st.floats(2.0, 17.0), d=offsets)
def test_left_of_the_road_is_positive(radius, s, d):
    assume(abs(d) > 0.5)
    frame = RoadFrame(bent_road(radius, count=20))
    x, y, _ = frame.to_local(np.array([s]), np.array([d]))
    from_center = math.hypot(x[0], y[0] - radius)
    assert (from_center < radius) == (d > 0)


def test_arc_lengths_are_counted_along_the_whole_route():
    road = straight_road().model_copy(update={"route_start_m": 1000.0, "key": "later"})
    s, _, _ = RoadFrame(road).to_road(np.array([[50.0, 0.0]]))
    assert s[0] == pytest.approx(1050.0)


@given(angle=st.floats(-100.0, 100.0))
def test_wrapped_angles_point_the_same_way(angle):
    wrapped = float(wrap_angle(np.array(angle)))
    assert -math.pi <= wrapped < math.pi + 1e-9
    assert math.cos(wrapped - angle) == pytest.approx(1.0)


@pytest.mark.parametrize(("d", "name"), [(0.0, "own"), (1.7, "own"), (1.8, "left"), (5.2, "left"), (7.0, "oncoming")])
def test_a_lane_is_found_by_its_borders(d, name):
    lane = road_frame(straight_road(left=LineKind.BROKEN)).lane_at(50.0, d)
    assert lane is not None
    assert lane.strip.id == name


@pytest.mark.parametrize("d", [-1.8, 8.8])
def test_beside_the_road_there_is_no_lane(d):
    assert road_frame(straight_road(left=LineKind.BROKEN)).lane_at(50.0, d) is None


def test_a_lane_ends_where_its_stations_end():
    short = strip("left", LANE_M, LaneDirection.SAME, LineKind.BROKEN, 50)
    road = straight_road(oncoming=None)
    frame = RoadFrame(road.model_copy(update={"lanes": (*road.lanes, short), "key": "short"}))
    assert frame.lane_at(40.0, LANE_M) is not None
    assert frame.lane_at(60.0, LANE_M) is None
    assert frame.beside(60.0, 0.0, +1) is None
    assert not frame.lanes[1].covers(40.0, 60.0)


def test_the_neighbor_on_a_side_is_the_nearest_one_there():
    frame = road_frame(straight_road(left=LineKind.BROKEN))
    own, left, oncoming = frame.lanes
    assert frame.beside(50.0, 0.0, +1) is left
    assert frame.beside(50.0, LANE_M, +1) is oncoming
    assert frame.beside(50.0, LANE_M, -1) is own
    assert frame.beside(50.0, 0.0, -1) is None


def test_only_connected_driving_lanes_are_drivable():
    road = straight_road(oncoming=None)
    walk = strip("walk", -LANE_M, LaneDirection.SAME, LineKind.KERB, 401).model_copy(update={"kind": LaneKind.SIDEWALK})
    far = strip("beyond a median", 3 * LANE_M, LaneDirection.OPPOSITE, LineKind.NONE, 401)
    low, high = RoadFrame(road.model_copy(update={"lanes": (*road.lanes, walk, far), "key": "median"})).drivable
    assert (low[50], high[50]) == (-LANE_M / 2, LANE_M / 2)


def test_lines_are_those_of_the_stretch_asked_for():
    lane = straight_road(oncoming=LineKind.BROKEN).lanes[1]
    mixed = (LineKind.BROKEN,) * 100 + (LineKind.SOLID,) * 301
    road = straight_road().model_copy(
        update={"lanes": (straight_road().lanes[0], lane.model_copy(update={"line": mixed})), "key": "mixed"}
    )
    lane = RoadFrame(road).lanes[1]
    assert lane.lines(50.0, 90.0) == {LineKind.BROKEN}
    assert lane.lines(90.0, 110.0) == {LineKind.BROKEN, LineKind.SOLID}


coordinates = st.floats(-12.0, 12.0)
angles = st.floats(-4.0, 4.0)
halves = st.tuples(st.floats(0.2, 4.0), st.floats(0.2, 1.5))


def polygon(pose, half):
    flat = box(-half[0], -half[1], half[0], half[1])
    return affinity.translate(affinity.rotate(flat, pose[2], origin=(0, 0), use_radians=True), pose[0], pose[1])


@given(a=st.tuples(coordinates, coordinates, angles), b=st.tuples(coordinates, coordinates, angles), x=halves, y=halves)
def test_separation_never_promises_more_than_the_true_distance(a, b, x, y):
    gap = float(separation(a, x, b, y))
    first, second = polygon(a, x), polygon(b, y)
    distance = first.distance(second)
    assert gap <= distance + 1e-9
    assert gap == pytest.approx(float(separation(b, y, a, x)))
    if gap < -1e-9:
        # Not by the area: GEOS gives the intersection of nearly equal boxes as points now and then.
        assert first.intersects(second)
    if gap > 1e-9:
        assert distance > 0.0


@given(distance=st.floats(-3.0, 20.0), turn=angles)
def test_separation_is_exact_face_to_face(distance, turn):
    ahead = 5.0 + distance
    b = (ahead * math.cos(turn), ahead * math.sin(turn), turn)
    assert float(separation((0.0, 0.0, turn), (2.5, 1.0), b, (2.5, 1.0))) == pytest.approx(
        max(distance, -2.0), abs=1e-9
    )


def test_a_view_puts_objects_beside_the_road():
    world = World(straight_road(), [thing("car", 70.0, 0.5), thing("walker", 80.0, -4.0, kind=ObjectKind.PEDESTRIAN)])
    view = world.view()
    assert view.gap[0] == pytest.approx(70.0 - 2.3 - 50.0 - 2.45)
    assert view.vulnerable.tolist() == [False, True]
    assert [lane and lane.strip.id for lane in view.lane_of] == ["own", None]
    assert view.index_of("walker") == 1
    assert view.index_of("nobody") is None


@given(yaw=st.floats(-3.1, 3.1), speed=st.floats(0.0, 15.0))
def test_view_keeps_speed_of_object_along_and_across(yaw, speed):
    """The view splits a velocity along and across the road and keeps the speed."""
    moving = thing("car", 70.0, yaw=yaw).model_copy(
        update={"vx_mps": speed * math.cos(yaw), "vy_mps": speed * math.sin(yaw)}
    )
    view = World(straight_road(), [moving]).view()
    assert math.hypot(view.vs[0], view.vd[0]) == pytest.approx(speed)
    assert view.along[0] >= min(4.6, 1.9) / 2 - 1e-9
    assert view.across[0] <= math.hypot(4.6, 1.9) / 2 + 1e-9


def test_what_is_not_listed_is_not_seen():
    surroundings = World(straight_road()).surroundings().model_copy(update={"sight": ()})
    view = type(World(straight_road()).view())(surroundings)
    assert view.sight_ahead_m(view.frame.lanes[1]) == 0.0


@pytest.mark.parametrize(
    ("ahead_m", "told"), [(12.4, "12 m ahead"), (0.4, "beside the ego"), (-0.3, "beside the ego"), (-3.0, "3 m behind")]
)
def test_places_are_told_as_people_say_them(ahead_m, told):
    assert whereabouts(ahead_m) == told


@pytest.mark.parametrize("stood_s", [0.0, 4.2, 9.5, 9.99])
def test_stood_too_briefly_never_rounds_time_up(stood_s):
    """A time at a standstill below the required one is never shown as long enough."""
    assert stood_too_briefly(stood_s, 10.0) == f"has been stationary for {int(stood_s)} s; 10 s are required"
