"""A picture shows the state that the world is in."""

from __future__ import annotations

import numpy as np
import pytest

from carlette.blueprints import AttributeType
from carlette.camera.models.lamps import VehicleLights
from carlette.camera.models.vehicle_body import frame_of
from carlette.camera.rendering.view import CameraView
from carlette.geometry import Pose, Rotation, Vector
from carlette.physics.doors import STOP_ARM
from carlette.world.actor import ActorKind
from carlette.world.settings import CLEAR_NOON
from carlette.world.spawn import spawn
from carlette.world.traffic_lights import Color
from carlette.world.world import World
from conftest import Camera
from straight import add, on_lane

CAR = "vehicle.lincoln.mkz_2020"


def painted(world, color: str, x: float = 40.0):
    return spawn(world, CAR, {"color": (AttributeType.COLOR, color)}, on_lane(x))


def changed(camera: Camera, act) -> np.ndarray:
    """Where the picture changes by what `act` does: (height, width), largest difference of a color."""
    before = camera.rgb()
    act()
    return np.abs(camera.rgb() - before).max(axis=2)


@pytest.mark.parametrize(("color", "channel"), (("230,10,10", 0), ("10,200,10", 1), ("10,10,230", 2)))
def test_a_car_has_the_color_of_its_attribute(world, color, channel) -> None:
    car = painted(world, color)
    camera = Camera(world)
    shown = camera.rgb()[camera.ids() == car.id]
    strong = shown[:, channel] > 1.6 * np.delete(shown, channel, axis=1).max(axis=1)
    assert strong.mean() > 0.25


@pytest.mark.parametrize(
    ("flag", "end", "side", "color"),
    (
        (VehicleLights.BRAKE, "rear", -1.0, (255, 26, 16)),
        (VehicleLights.LEFT_BLINKER, "rear", -1.0, (255, 158, 0)),
        (VehicleLights.RIGHT_BLINKER, "rear", 1.0, (255, 158, 0)),
        (VehicleLights.REVERSE, "rear", 1.0, (255, 252, 236)),
        (VehicleLights.LOW_BEAM, "front", 1.0, (255, 252, 236)),
        (VehicleLights.RIGHT_BLINKER, "front", 1.0, (255, 158, 0)),
    ),
)
def test_a_lamp_is_lit_at_its_place_in_its_color(world, flag, end, side, color) -> None:
    car = add(world, CAR, x=38.0, yaw=0.0 if end == "rear" else 180.0)
    camera = Camera(world, size=(640, 360))
    frame = frame_of(CAR, car.box)
    x, z = (frame.rear, frame.tail_z) if end == "rear" else (frame.front, frame.lamp_z)
    place = camera.around(car, x, frame.y + side * frame.lamp_half * 0.9, z, half=14)
    other = camera.around(car, x, frame.y - side * frame.lamp_half * 0.9, z, half=14)

    def lit(where) -> int:
        return int((np.abs(camera.rgb()[where] - np.array(color)).max(axis=2) < 40).sum())

    assert lit(place) == 0
    world.fleet.light_state[car.index] = int(flag)
    assert lit(place) >= 6
    if flag in (VehicleLights.LEFT_BLINKER, VehicleLights.RIGHT_BLINKER):
        assert lit(other) == 0


def test_indicators_blink_with_the_worlds_time(world) -> None:
    car = add(world, CAR, x=38.0)
    world.fleet.light_state[car.index] = int(VehicleLights.LEFT_BLINKER)
    camera, seen = Camera(world, size=(160, 90)), set()
    for _ in range(20):
        world.tick()
        seen.add(camera.rgb().tobytes())
    assert len(seen) == 2


def test_an_open_door_stands_out_where_others_run_into_it(world) -> None:
    car = add(world, CAR, x=40.0)
    camera = Camera(world, x=30.0, y=-1.0, size=(640, 360))

    def open_door() -> None:
        world.doors.move(car.row, car.box, 0, True)
        world.doors.swing[:] = 1.0

    beside = camera.around(car, 0.3, -car.box.extent.y - 0.35, 0.7, half=2)
    assert changed(camera, open_door)[beside].min() > 20


def test_a_school_buss_arm_shows_a_red_sign(world) -> None:
    bus = add(world, "vehicle.carlette.schoolbus", x=44.0)
    camera = Camera(world, x=30.0, y=-1.75, size=(640, 360))
    place = camera.around(bus, 0.30 * bus.box.extent.x, -bus.box.extent.y - 0.8, 1.45, half=8)
    reddish = [self_red(camera.rgb()[place])]
    world.doors.move(bus.row, bus.box, STOP_ARM, True)
    world.doors.swing[:] = 1.0
    reddish.append(self_red(camera.rgb()[place]))
    assert reddish[0] == 0 and reddish[1] > 20


def self_red(part: np.ndarray) -> int:
    return int(((part[..., 0] > 100) & (part[..., 0] > 2 * part[..., 1]) & (part[..., 0] > 2 * part[..., 2])).sum())


@pytest.mark.parametrize(
    ("color", "shown"),
    ((Color.RED, (255, 36, 24)), (Color.YELLOW, (255, 190, 20)), (Color.GREEN, (30, 240, 120)), (Color.OFF, None)),
)
def test_traffic_light_lamp_is_lit_only_toward_governed_lane(town, color, shown) -> None:
    """The lamp of the present color is lit toward the lane that the light governs, and not from behind."""
    world = World(town)
    light = next(actor for actor in world.actors.values() if actor.kind is ActorKind.LIGHT)
    world.signals.set_color(light.index, color)
    pose = world.pose(light)
    camera = Camera(world, size=(640, 360))
    for back_m, is_seen in ((9.0, True), (-14.0, False)):
        stop = pose.apply(Vector(light.box.center.x, light.box.center.y + back_m, 2.0))
        yaw = pose.rotation.yaw - 90.0 + (0.0 if is_seen else 180.0)
        camera.view = CameraView(Pose(stop, Rotation(8.0, yaw, 0.0)), 640, 360, 90.0)
        own = camera.ids() == light.id
        assert own.any()
        lamps = {lamp: near(camera.rgb()[own], lit) for lamp, lit in LAMPS.items()}
        wanted = {lamp: lamp is color and is_seen and shown is not None for lamp in LAMPS}
        assert {lamp: count > 8 for lamp, count in lamps.items()} == wanted


LAMPS = {Color.RED: (255, 36, 24), Color.YELLOW: (255, 190, 20), Color.GREEN: (30, 240, 120)}


def near(pixels: np.ndarray, color) -> int:
    return int((np.abs(pixels - np.array(color)).max(axis=1) < 45).sum())


def test_a_walkers_legs_move_with_its_way(world) -> None:
    walker = add(world, "walker.pedestrian.0002", x=36.0, z=0.93)
    world.walkers.control[walker.index] = (0.0, -1.0, 0.0, 1.4, 0.0)
    camera, shapes = Camera(world, size=(320, 180)), set()
    for _ in range(20):
        world.tick()
        rows, columns = np.nonzero(camera.ids() == walker.id)
        shapes.add(int(np.ptp(columns[rows > np.percentile(rows, 80)])))
    assert max(shapes) - min(shapes) >= 5


def test_a_flagger_shows_what_it_signs(world) -> None:
    def view(gesture: str) -> np.ndarray:
        attributes = {"gesture": (AttributeType.STRING, gesture)}
        actor = spawn(world, "walker.flagger.0001", attributes, on_lane(34.0, z=0.93, yaw=180.0))
        shown = Camera(world, size=(320, 180)).rgb()
        world.remove(actor.id)
        return shown

    nothing, stop, slow = (view(item) for item in ("none", "stop", "slow"))
    assert self_red(stop) > self_red(nothing) + 40
    assert orange(slow) > orange(nothing) + 40


def orange(part: np.ndarray) -> int:
    red, green, blue = (part[..., item] for item in range(3))
    return int(((red > 100) & (green > 0.4 * red) & (green < 0.72 * red) & (blue < 0.25 * red)).sum())


def weather(world, **numbers: float) -> None:
    values = list(CLEAR_NOON)
    for index, value in numbers.items():
        values[int(index[1:])] = value
    world.weather = tuple(values)


def test_night_is_darker_than_dusk_than_day(world) -> None:
    camera, means = Camera(world), []
    for altitude in (-40.0, -2.0, 45.0):
        weather(world, w5=altitude)
        means.append(camera.rgb().mean())
    assert means[0] < 0.75 * means[1] and means[1] < 0.75 * means[2]


def test_fog_hides_what_is_far_and_not_what_is_near(world) -> None:
    near_car, far_car = painted(world, "230,10,10", 36.0), painted(world, "230,10,10", 90.0)
    camera = Camera(world, z=3.0, size=(640, 360))

    def redness(car) -> float:
        shown = camera.rgb()[camera.ids() == car.id]
        return float((shown[:, 0] - shown[:, 1]).mean())

    clear = redness(near_car), redness(far_car)
    weather(world, w6=80.0)
    assert redness(near_car) > 0.55 * clear[0]
    assert redness(far_car) < 0.25 * clear[1]


def test_a_wet_road_is_darker_and_rain_is_seen(world) -> None:
    camera = Camera(world, pitch=-20.0)
    dry = camera.rgb()
    weather(world, w9=100.0)
    wet = camera.rgb()
    assert wet[120:].mean() < 0.85 * dry[120:].mean()
    weather(world, w9=100.0, w1=90.0)
    world.tick()
    first = camera.rgb()
    world.tick()
    assert (camera.rgb() != first).any(axis=2).mean() > 0.002


def test_a_low_sun_is_warm(world) -> None:
    camera = Camera(world, pitch=10.0)
    noon = camera.rgb()[:80]
    weather(world, w5=3.0)
    dusk = camera.rgb()[:80]
    assert (dusk[..., 0] - dusk[..., 2]).mean() > (noon[..., 0] - noon[..., 2]).mean() + 20
