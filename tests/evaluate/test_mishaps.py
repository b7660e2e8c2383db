"""Collisions and near misses of the demo's runs: counted as Bench2Drive and the evaluation count."""

from __future__ import annotations

import time

import pytest

carla = pytest.importorskip("carla")

from stucksolver_eval.mishaps import Mishaps  # noqa: E402
from stucksolver_eval.server import carlette_server  # noqa: E402

pytestmark = pytest.mark.integration

DT_S = 0.05


class Street:
    """A straight lane of the demo town; places are metres along it."""

    def __init__(self, client) -> None:
        self.world = client.reload_world()
        settings = self.world.get_settings()
        settings.synchronous_mode, settings.fixed_delta_seconds = True, DT_S
        self.world.apply_settings(settings)
        self._library, self._map = self.world.get_blueprint_library(), self.world.get_map()
        self.told = []
        self._sensor = None

    def put(self, s: float, kind: str = "vehicle.tesla.model3", aside_m: float = 0.0):
        transform = self._map.get_waypoint_xodr(11, -1, s).transform
        transform.location += aside_m * transform.get_right_vector() + carla.Location(z=0.2)
        return self.world.spawn_actor(self._library.find(kind), transform)

    def ego(self, s: float):
        found = self.put(s)
        self.world.tick()
        self.mishaps = Mishaps(self.world, found)
        return found

    def feel(self, car):
        """Every contact, as a sensor of our own hears it."""
        heard = []
        # Kept: the client stops a sensor that nobody holds.
        self._sensor = self.world.spawn_actor(
            self._library.find("sensor.other.collision"), carla.Transform(), attach_to=car
        )
        self._sensor.listen(heard.append)
        return heard

    def drive(self, seconds: float) -> dict[str, int]:
        for k in range(round(seconds / DT_S)):
            self.world.tick()
            time.sleep(0.002)
            self.told += self.mishaps.update(k * DT_S)
        self.told += self.mishaps.finish()
        return self.mishaps.counts


@pytest.fixture(scope="module")
def client():
    with carlette_server("demo_town") as server:
        found = carla.Client(server.host, server.port)
        found.set_timeout(15.0)
        yield found


@pytest.fixture
def street(client):
    found = Street(client)
    yield found
    found.mishaps.close()
    if found._sensor is not None:
        found._sensor.destroy()


def roll(car, mps: float) -> None:
    car.enable_constant_velocity(carla.Vector3D(mps, 0.0, 0.0))


def test_a_long_contact_is_one_collision_and_none_is_counted_after_close(street):
    street.put(55.0)
    roll(street.ego(40.0), 6.0)
    assert street.drive(6.0)["collisions_vehicle"] == 1
    street.mishaps.close()
    for _ in range(20):
        street.world.tick()
    assert street.mishaps.counts["collisions_vehicle"] == 1
    assert "collision with vehicle.tesla.model3" in " ".join(one.text for one in street.told)


def test_two_others_at_one_place_are_one_collision(street):
    street.put(52.0, "static.prop.trafficcone01", aside_m=-0.8)
    street.put(52.0, "static.prop.trafficcone01", aside_m=0.8)
    ego = street.ego(40.0)
    felt = street.feel(ego)
    roll(ego, 5.0)
    assert street.drive(2.4).get("collisions_layout") == 1
    assert len({event.other_actor.id for event in felt}) == 2


def test_who_is_walked_into_while_standing_is_not_blamed_but_has_had_a_near_miss(street):
    person = street.put(47.0, "walker.pedestrian.0001")
    ego = street.ego(52.0)
    ego.apply_control(carla.VehicleControl(brake=1.0, hand_brake=True))
    felt = street.feel(ego)
    ahead = person.get_transform().get_forward_vector()
    person.apply_control(carla.WalkerControl(direction=ahead, speed=1.5))
    assert street.drive(4.0) == {"near_miss": 1}
    assert {event.other_actor.id for event in felt} == {person.id}
    assert [one.kind for one in street.told] == ["near_miss"]
