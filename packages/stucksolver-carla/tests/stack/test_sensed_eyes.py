"""A vehicle that sees by its own sensors, in a street of the embedded simulator."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import carla
import pytest

from stucksolver.scene import LightState, ObjectKind
from stucksolver_carla.client_connection import connect
from stucksolver_carla.drivers.behavior import BehaviorDriver
from stucksolver_carla.stack import CarlaStack
from stucksolver_eval.simulator_server import carlette_server, set_synchronous
from stucksolver_perception.carla import EgoPerception, SensorFault
from stucksolver_perception.lidar.lidar_miscalibration import LidarAlignment
from stucksolver_perception.lidar_labels import LABELS

pytestmark = pytest.mark.integration

AHEAD_M = 13.0
TICKS = 60
CAR = "vehicle.tesla.model3"


@pytest.fixture(scope="module")
def world() -> Iterator[Any]:
    with carlette_server("demo_town", scenery=True) as server:
        client = connect(server, 20.0)
        found = client.get_world()
        set_synchronous(found, 0.05)
        yield found


@pytest.fixture
def street(world: Any) -> Iterator[tuple[Any, Any]]:
    """The ego, and a car that stands some way ahead of it in its lane."""
    library, start = world.get_blueprint_library(), world.get_map().get_spawn_points()[0]
    lane = world.get_map().get_waypoint(start.location)
    there = lane.next(AHEAD_M)[0].transform
    there.location.z += 0.3
    ego = world.spawn_actor(library.find("vehicle.lincoln.mkz_2020"), start)
    other = world.spawn_actor(library.find(CAR), there)
    world.tick()
    yield ego, other
    other.destroy()
    ego.destroy()
    world.tick()


def looked(world: Any, ego: Any, ticks: int = TICKS, fault: SensorFault | None = None) -> EgoPerception:
    eyes = EgoPerception(ego, world.get_map(), seed=3, fault=fault)
    for _ in range(ticks):
        world.tick()
        eyes.tick()
    return eyes


def test_it_knows_where_it_is_and_what_stands_ahead(world: Any, street: tuple[Any, Any]) -> None:
    ego, other = street
    eyes = looked(world, ego)
    try:
        place, there = ego.get_location(), other.get_location()
        assert math.hypot(eyes.pose.x_m - place.x, eyes.pose.y_m + place.y) < 0.6
        assert eyes.percept is not None
        off = eyes.pose.x_m - place.x, eyes.pose.y_m + place.y
        near = [t for t in eyes.percept.tracks if math.hypot(t.x_m - there.x - off[0], t.y_m + there.y - off[1]) < 0.6]
        assert [LABELS[track.label] for track in near] == ["car"]
        assert near[0].vx_mps == near[0].vy_mps == 0.0
    finally:
        eyes.close()


@pytest.mark.release
def test_the_stack_tells_the_solver_what_the_sensors_saw(world: Any, street: tuple[Any, Any]) -> None:
    ego, other = street
    eyes = looked(world, ego)
    try:
        driver = BehaviorDriver(eyes.vehicle, carla_map=world.get_map())
        driver.set_destination(world.get_map().get_waypoint(ego.get_location()).next(60.0)[0].transform.location)
        stack = CarlaStack(eyes.vehicle, driver)
        stack.status()
        seen = stack.surroundings()
        assert stack.perception == "sensors"
        assert 0.0 < seen.age_s <= 0.16
        assert seen.ego.position_sd_m is not None and 0.0 < seen.ego.position_sd_m < 0.5
        there = other.get_location()
        car = min(seen.objects, key=lambda obj: math.hypot(obj.x_m - there.x, obj.y_m + there.y))
        assert car.kind is ObjectKind.CAR
        assert car.position_sd_m is not None and car.position_sd_m > 0.0
        assert car.id != str(other.id), "the client's own ids are not known to sensors"
        assert max(sight.ahead_m for sight in seen.sight) > 5.0
        control = driver.run_step()
        assert driver.hazard is not None and abs(driver.hazard.gap - (AHEAD_M - 4.9)) < 1.5
        assert isinstance(control, carla.VehicleControl)
    finally:
        eyes.close()


@pytest.mark.parametrize("fault", ["lidar-missing", "lidar-frozen"])
def test_whoever_has_gone_blind_brakes(world: Any, street: tuple[Any, Any], fault: str) -> None:
    ego, _ = street
    eyes = looked(world, ego, 12, SensorFault(fault, since_s=0.2))
    try:
        go = carla.VehicleControl(throttle=0.7, steer=0.1)
        for _ in range(20):
            world.tick()
            eyes.tick()
        assert eyes.blind and eyes.health.faults
        checked = eyes.checked(go)
        assert (checked.throttle, checked.brake) == (0.0, 1.0)
        assert checked.steer == pytest.approx(0.1)
    finally:
        eyes.close()


def test_turned_lidar_measured_brakes_and_stays_stopped(
    world: Any, street: tuple[Any, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A vehicle that has measured that its LiDAR is turned brakes and stays stopped."""
    ego, _ = street
    measured = iter([math.radians(-2.0)])
    # It says so once, as a vehicle that stands afterwards measures nothing.
    monkeypatch.setattr(LidarAlignment, "turned_rad", property(lambda _: next(measured, None)))
    eyes = looked(world, ego, 30)
    try:
        assert eyes.health.faults == ("the LiDAR seems turned by 2.0 degrees to the right",)
        assert eyes.blind
        assert eyes.checked(carla.VehicleControl(throttle=0.7)).brake == 1.0
    finally:
        eyes.close()


def test_a_black_picture_makes_no_light_green(world: Any, street: tuple[Any, Any]) -> None:
    ego, _ = street
    eyes = looked(world, ego, 20, SensorFault("camera-black"))
    try:
        assert eyes.percept is not None
        assert set(eyes.percept.lights.values()) <= {LightState.UNKNOWN}
        assert any("camera" in fault for fault in eyes.health.faults)
        assert not eyes.blind, "the LiDAR still sees"
    finally:
        eyes.close()


@pytest.mark.release
@pytest.mark.parametrize(
    ("blueprint", "kind"), [("vehicle.ford.ambulance", ObjectKind.EMERGENCY), (CAR, ObjectKind.CAR)]
)
def test_the_rear_camera_recognizes_an_ambulance_with_its_lights_on(
    world: Any, blueprint: str, kind: ObjectKind
) -> None:
    """A car in the same place shows that the answer comes from the picture."""
    library, start = world.get_blueprint_library(), world.get_map().get_spawn_points()[0]
    there = world.get_map().get_waypoint(start.location).next(25.0)[0].transform
    there.location.z += 0.3
    ego = world.spawn_actor(library.find("vehicle.lincoln.mkz_2020"), there)
    other = world.spawn_actor(library.find(blueprint), start)
    if kind is ObjectKind.EMERGENCY:
        other.set_light_state(
            carla.VehicleLightState(carla.VehicleLightState.Special1 | carla.VehicleLightState.Special2)
        )
    world.tick()
    eyes = looked(world, ego, 80)
    try:
        assert eyes.percept is not None
        behind = [
            track
            for track in eyes.percept.tracks
            if 20.0 < math.hypot(track.x_m - eyes.pose.x_m, track.y_m - eyes.pose.y_m) < 30.0
        ]
        told = [eyes.percept.attributes[item.id] for item in behind if item.id in eyes.percept.attributes]
        assert [(item.kind, item.emergency_lights) for item in told] == [(kind, kind is ObjectKind.EMERGENCY)]
    finally:
        eyes.close()
        ego.destroy()
        other.destroy()
        world.tick()
