"""Things are in the picture where they are in the world."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from carlette.camera.rendering import tags
from carlette.camera.rendering.renderer import Renderer
from carlette.camera.rendering.view import CameraView, axes_of
from carlette.geometry import Pose, Rotation, Vector, rotate
from carlette.world.rays import cast as cast_ray
from conftest import Camera
from straight import add


def assert_in_its_box(camera: Camera, actor, least: float = 0.7, span_px: float = 1.5) -> None:
    rows, columns = np.nonzero(camera.ids() == actor.id)
    box = camera.corners(actor)
    low, high = box[:, :2].min(axis=0), box[:, :2].max(axis=0)
    assert len(rows), "the actor is not in the picture"
    assert columns.min() >= low[0] - span_px and columns.max() + 1 <= high[0] + span_px
    assert rows.min() >= low[1] - span_px and rows.max() + 1 <= high[1] + span_px
    width, height = np.ptp(columns) + 1, np.ptp(rows) + 1
    assert width > least * (high[0] - low[0]) - 1 and height > least * (high[1] - low[1]) - 1


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    ahead=st.floats(9.0, 40.0), yaw=st.floats(-180.0, 180.0), turn=st.floats(-20.0, 20.0),
    pitch=st.floats(-10.0, 8.0), roll=st.floats(-15.0, 15.0),
)  # fmt: skip
def test_a_car_fills_its_projected_box_and_no_more(world, ahead, yaw, turn, pitch, roll) -> None:
    car = add(world, x=30.0 + ahead, yaw=yaw)
    camera = Camera(world)
    camera.view = CameraView(Pose(Vector(30.0, 1.75, 1.6), Rotation(pitch, turn, roll)), 640, 360, 100.0)
    try:
        assert_in_its_box(camera, car, 0.65)
    finally:
        world.remove(car.id)


@pytest.mark.parametrize(
    "type_id",
    (
        "vehicle.carlamotors.firetruck", "vehicle.carlette.schoolbus", "vehicle.mitsubishi.fusorosa",
        "vehicle.ford.ambulance", "vehicle.bh.crossbike", "vehicle.kawasaki.ninja", "vehicle.micro.microlino",
        "walker.pedestrian.0001", "walker.pedestrian.0010", "animal.cow", "static.prop.streetbarrier",
        "static.prop.container", "static.prop.trafficcone01", "static.prop.rock", "static.prop.paperbag",
    ),
)  # fmt: skip
def test_whatever_it_is_it_fills_its_box(world, type_id) -> None:
    up_m = {"walker.pedestrian.0001": 0.93, "walker.pedestrian.0010": 0.55, "animal.cow": 0.725}.get(type_id, 0.0)
    actor = add(world, type_id, x=46.0, z=up_m, yaw=30.0)
    assert_in_its_box(Camera(world, size=(640, 360), fov=60.0), actor, 0.4, 3.5)


def test_the_field_of_view_is_the_horizontal_one(world) -> None:
    view = Camera(world, fov=60.0, size=(400, 300)).view
    edge = np.array([30.0 + 10.0, 1.75 + 10.0 * math.tan(math.radians(30.0)), 1.6])
    assert view.pixels(edge[None])[0] == pytest.approx([400.0, 150.0, 10.0])


@pytest.mark.parametrize("size", ((1, 1), (7, 3), (321, 181), (64, 640), (1600, 900)))
def test_pictures_have_the_size_that_was_asked_for(world, size) -> None:
    camera = Camera(world, size=size)
    for picture in (camera.rgb(), camera.tags(), camera.depth()):
        assert picture.shape[:2] == (size[1], size[0])


def test_depth_is_the_distance_to_the_thing(world) -> None:
    box = add(world, "static.prop.box01", x=42.0)
    camera = Camera(world, z=0.4)
    depth = camera.depth()[camera.around(box, x=-box.box.extent.x, z=0.4, half=1)]
    assert depth == pytest.approx(np.full(depth.shape, 12.0 - box.box.extent.x), rel=0.01, abs=0.05)


def test_depth_of_the_road_is_that_of_rays(world) -> None:
    camera = Camera(world, pitch=-6.0, yaw=3.0)
    depth, seen = camera.depth(), camera.tags()
    axes, (across, up) = camera.view.axes(), camera.view.tangents
    checked = 0
    for v in range(100, 180, 9):
        for u in range(5, 320, 23):
            if seen[v, u] not in (tags.ROAD, tags.ROAD_LINE):
                continue
            right, rise = ((u + 0.5) / 160 - 1) * across, (1 - (v + 0.5) / 90) * up
            way = axes.T @ np.array([1.0, right, rise])
            hits = cast_ray(world, camera.view.pose.location, Vector(*way), 200.0)
            assert hits and depth[v, u] == pytest.approx(
                hits[0].distance_m / math.hypot(1.0, right, rise), rel=0.01, abs=0.05
            )
            checked += 1
    assert checked > 40


def test_depth_of_the_sky_is_a_thousand_meters(world) -> None:
    camera = Camera(world, pitch=40.0)
    sky = camera.tags() == tags.SKY
    assert sky.mean() > 0.5
    assert camera.depth()[sky] == pytest.approx(1000.0, rel=0.01)


def test_nearer_things_hide_others(world) -> None:
    near, far = add(world, x=40.0), add(world, x=50.0)
    ids = Camera(world, z=0.7).ids()
    assert (ids == near.id).sum() > 20 * (ids == far.id).sum()


def test_tags_are_those_of_what_is_there(world) -> None:
    wanted = {
        "vehicle.tesla.model3": tags.CAR,
        "vehicle.carlamotors.carlacola": tags.TRUCK,
        "vehicle.mitsubishi.fusorosa": tags.BUS,
        "walker.pedestrian.0002": tags.PEDESTRIAN,
    }
    for type_id, tag in wanted.items():
        actor = add(world, type_id, x=45.0, z=0.93 if "walker" in type_id else 0.0)
        camera = Camera(world)
        middle = actor.box.center
        assert (camera.tags()[camera.around(actor, z=middle.z, half=0)] == tag).all(), type_id
        world.remove(actor.id)


def test_riders_have_a_tag_of_their_own(world) -> None:
    add(world, "vehicle.gazelle.omafiets", x=36.0)
    assert {tags.RIDER, tags.BICYCLE} <= set(np.unique(Camera(world).tags()).tolist())


def test_camera_tags_match_positions_on_map(world) -> None:
    """Road, sidewalk, road lines and sky are in the image where the map has them."""
    camera = Camera(world, pitch=-10.0)

    def tag_at(x: float, y: float, z: float = 0.0) -> int:
        u, v, _ = camera.view.pixels(np.array([[x, y, z]]))[0]
        return int(camera.tags()[int(v), int(u)])

    assert tag_at(40.0, 1.75) == tags.ROAD
    assert tag_at(40.0, 5.25, 0.15) == tags.SIDEWALK
    assert tags.ROAD_LINE in camera.tags()
    assert int(Camera(world, pitch=45.0).tags()[90, 160]) == tags.SKY


def test_the_same_painter_serves_any_sequence_of_sizes(world) -> None:
    renderer, camera = Renderer(), Camera(world)
    first = renderer.rgb(camera.shot, camera.view)
    for size in ((1600, 900), (10, 10), (800, 450)):
        renderer.rgb(camera.shot, CameraView(camera.view.pose, *size, 90.0))
        renderer.depth(camera.shot, CameraView(camera.view.pose, *size, 90.0))
    assert (renderer.rgb(camera.shot, camera.view) == first).all()


@given(st.floats(-180, 180), st.floats(-90, 90), st.floats(-180, 180))
def test_cameras_turn_as_actors_do(yaw, pitch, roll) -> None:
    rotation = Rotation(pitch, yaw, roll)
    expected = [rotate(item, rotation) for item in (Vector(x=1.0), Vector(y=1.0), Vector(z=1.0))]
    assert axes_of(rotation) == pytest.approx(np.array(expected), abs=1e-9)
