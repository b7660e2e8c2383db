"""Rays of LiDAR and radar against an exact caster that tries every triangle on every ray."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from carlette.geometry import Pose, Rotation, Vector
from carlette.opendrive.map_file import find_map, map_folders
from carlette.opendrive.road_network import RoadNetwork
from carlette.sensors.kernels import warm_up
from carlette.sensors.rotations import axes, many_axes, turn_between
from carlette.sensors.sensor_scene import SensorScene
from carlette.world.spawn import spawn
from carlette.world.world import World

REACH_M = 25.0
AZIMUTHS = np.radians(np.arange(-180.0, 180.0, 7.3))
TANGENTS = np.tan(np.radians(np.arange(-60.0, 31.0, 6.0)))[None, :]


@pytest.fixture(scope="module")
def scene() -> SensorScene:
    """A street with a car that has a door open, a bus, a cyclist, people and cones."""
    warm_up()
    world = World(RoadNetwork(find_map("demo_town", map_folders([]))))
    spot = world.roads.spawn_points()[3]
    kinds = ("vehicle.tesla.model3", "vehicle.mitsubishi.fusorosa", "vehicle.bh.crossbike", "walker.pedestrian.0005")
    for number, kind in enumerate((*kinds, "static.prop.constructioncone", "animal.dog")):
        actor = spawn(
            world, kind, {}, spot.compose(Pose(Vector(9.0 * number - 12.0, 0.0, 0.6), Rotation(yaw=33.0 * number)))
        )
        if kind == "vehicle.tesla.model3":
            world.doors.move(actor.row, actor.box, 0, True)
    for _ in range(40):
        world.tick()
    return SensorScene(world)


def exact(scene: SensorScene, pose: Pose, ways: np.ndarray) -> np.ndarray:
    """Distances (n,) of rays with directions `ways` (n, 3), world frame; infinity where nothing is met."""
    faces, cast = scene.static, scene.cast
    body = cast.body_of
    moved = np.einsum(
        "nij,nkj->nki", many_axes(scene.world.bodies.rotation[[a.row for a in cast.actors]])[body], cast.faces.corners
    )
    moved = moved + scene.world.bodies.position[[a.row for a in cast.actors]][body][:, None, :]
    corners = np.concatenate([faces.corners.astype(float), moved]) - np.array(pose.location)
    middles = corners.mean(axis=1)
    sizes = np.linalg.norm(corners - middles[:, None, :], axis=2).max(axis=1)
    corners = corners[np.linalg.norm(middles, axis=1) < REACH_M + sizes]
    found = np.full(len(ways), np.inf)
    for a, b, c in ((0, 1, 2), (0, 2, 3)):
        first, u, v = corners[:, a], corners[:, b] - corners[:, a], corners[:, c] - corners[:, a]
        normal = np.cross(u, v)
        solid = np.linalg.norm(normal, axis=1) > 1e-7
        first, u, v, normal = first[solid], u[solid], v[solid], normal[solid]
        height, square = (normal * first).sum(axis=1), (normal**2).sum(axis=1)
        for index, way in enumerate(ways):
            slope = normal @ way
            front = np.flatnonzero((slope < 0) & (height < 0))
            reach = height[front] / slope[front]
            gap = reach[:, None] * way - first[front]
            share_v = (np.cross(u[front], gap) * normal[front]).sum(axis=1) / square[front]
            share_u = (np.cross(gap, v[front]) * normal[front]).sum(axis=1) / square[front]
            inside = (share_u >= -1e-9) & (share_v >= -1e-9) & (share_u + share_v <= 1 + 1e-9)
            found[index] = min(found[index], reach[inside].min(initial=np.inf))
    return found


@pytest.mark.integration
@settings(max_examples=10, phases=(Phase.explicit, Phase.reuse, Phase.generate))
@given(
    x=st.floats(-15.0, 15.0),
    y=st.floats(-6.0, 6.0),
    z=st.floats(0.4, 8.0),
    pitch=st.floats(-90.0, 90.0),
    yaw=st.floats(-180.0, 180.0),
    roll=st.floats(-180.0, 180.0),
)
def test_ray_ranges_match_exact_caster_at_any_tilt(
    scene: SensorScene, x: float, y: float, z: float, pitch: float, yaw: float, roll: float
) -> None:
    """Every range is that of an exact ray caster, however the sensor is tilted."""
    spot = scene.world.roads.spawn_points()[3]
    pose = Pose(spot.apply(Vector(x, y, z)), Rotation(pitch, yaw, roll))
    columns = AZIMUTHS[::6]
    sweep = scene.sweep(pose, columns, TANGENTS, REACH_M)
    slopes = np.arctan(TANGENTS[0])
    flat = np.stack([np.cos(columns), np.sin(columns), np.zeros(len(columns))], axis=1)
    ways = flat[:, None, :] * np.cos(slopes)[None, :, None] + np.sin(slopes)[None, :, None] * np.array([0.0, 0.0, 1.0])
    truth = exact(scene, pose, ways.reshape(-1, 3) @ axes(pose.rotation).T)
    met = truth < REACH_M
    off = np.abs(np.where(sweep.hit.ravel() >= 0, 1.0 / sweep.nearness.ravel(), np.inf)[met] - truth[met])
    # A ray may slip through between two edges that only nearly meet, on either side of the comparison.
    assert (off < 2e-3).mean() > 0.99
    assert np.median(off) < 1e-5
    beyond = sweep.hit.ravel()[truth > REACH_M + 0.01]
    assert (beyond >= 0).sum() <= 0.01 * len(beyond)


@given(st.lists(st.floats(-180, 180), min_size=3, max_size=3), st.lists(st.floats(-180, 180), min_size=3, max_size=3))
def test_child_attitude_composes_with_parent_attitude(parent: list[float], child: list[float]) -> None:
    """The attitude of a child is composed of its own and that of its parent."""
    together = Pose(Vector(), Rotation(*parent)).compose(Pose(Vector(), Rotation(*child)))
    assert axes(together.rotation) == pytest.approx(axes(Rotation(*parent)) @ axes(Rotation(*child)), abs=1e-6)


@given(st.floats(-0.5, 0.5), st.floats(-180, 180), st.floats(-60, 60))
def test_attitude_change_is_the_rotation_that_made_it(rate: float, yaw: float, pitch: float) -> None:
    """A change of attitude is measured as the rotation that made it."""
    before = axes(Rotation(pitch, yaw, 10.0))
    cos, sin = np.cos(rate), np.sin(rate)
    about_z = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    assert turn_between(before, about_z @ before) == pytest.approx([0.0, 0.0, rate], abs=1e-9)


@pytest.mark.integration
def test_rays_hit_road_sidewalk_and_objects_at_roadside(scene: SensorScene) -> None:
    """The rays hit the road, the sidewalk, and the building and the car next to it."""
    spot = scene.world.roads.spawn_points()[3]
    pose = Pose(spot.apply(Vector(z=2.0)), spot.rotation)
    sweep = scene.sweep(pose, AZIMUTHS, TANGENTS, 60.0)
    tags = set(scene.face_tags[sweep.hit[sweep.hit >= 0]].tolist())
    assert {1, 2, 3, 14} <= tags  # road, sidewalk, building, car
