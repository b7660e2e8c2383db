"""Weather, rays, the spectator, and what is there for the eye only."""

from __future__ import annotations

import math

import pytest
from stage import above, run, settled

carla = pytest.importorskip("carla")

FIELDS = (
    *("cloudiness", "precipitation", "precipitation_deposits", "wind_intensity"),
    *("sun_azimuth_angle", "sun_altitude_angle", "fog_density", "fog_distance", "fog_falloff", "wetness"),
    *("scattering_intensity", "mie_scattering_scale", "rayleigh_scattering_scale", "dust_storm"),
)


def test_all_fourteen_numbers_of_the_weather_are_kept(world) -> None:
    before = world.get_weather()
    given = carla.WeatherParameters(*[float(number) for number in range(1, 15)])
    world.set_weather(given)
    found = world.get_weather()
    assert [getattr(found, name) for name in FIELDS] == [float(number) for number in range(1, 15)]
    assert found == given
    world.set_weather(before)


def test_ready_made_weathers_are_kept(world) -> None:
    for weather in (carla.WeatherParameters.HardRainNoon, carla.WeatherParameters.ClearSunset):
        world.set_weather(weather)
        assert world.get_weather() == weather


def test_the_spectator_goes_where_it_is_put(world, spots) -> None:
    place = above(spots[0], 30.0)
    world.get_spectator().set_transform(place)
    world.tick()
    assert world.get_spectator().get_location().distance(place.location) < 0.01


def test_a_point_above_the_road_projects_onto_it(world, spots) -> None:
    place = above(spots[0], 5.0).location
    on_road = world.get_map().get_waypoint(place).transform.location
    hit = world.ground_projection(place, 20.0)
    assert hit.location.z == pytest.approx(on_road.z, abs=0.1)
    assert hit.location.distance(carla.Location(place.x, place.y, hit.location.z)) < 0.01


def test_where_nothing_is_below_there_is_no_projection(world, spots) -> None:
    assert world.ground_projection(above(spots[0], 50.0).location, 5.0) is None


def test_cast_ray_hits_car_before_road(world, spots) -> None:
    """A ray through a car hits the car first and then the road."""
    settled(world, spots[0])
    hits = world.cast_ray(above(spots[0], 10.0).location, above(spots[0], -5.0).location)
    labels = [hit.label for hit in hits]
    assert labels[0] == carla.CityObjectLabel.Car
    assert carla.CityObjectLabel.Roads in labels
    first = world.project_point(above(spots[0], 10.0).location, carla.Vector3D(0.0, 0.0, -1.0), 20.0)
    assert first.label == carla.CityObjectLabel.Car
    assert first.location.z > hits[labels.index(carla.CityObjectLabel.Roads)].location.z


@pytest.mark.carlette_only
def test_the_boxes_of_a_label_are_those_of_its_actors(world, spots) -> None:
    car = settled(world, spots[0])
    (box,) = world.get_level_bbs(carla.CityObjectLabel.Car)
    assert box.extent.x == pytest.approx(car.bounding_box.extent.x)
    assert math.hypot(box.location.x - car.get_location().x, box.location.y - car.get_location().y) < 1.0


@pytest.mark.carlette_only
def test_there_is_no_scenery_and_no_street_light(world) -> None:
    assert list(world.get_environment_objects(carla.CityObjectLabel.Any)) == []
    assert list(world.get_names_of_all_objects()) == []
    assert list(world.get_lightmanager().get_all_lights()) == []


def test_street_lights_can_be_switched_even_where_there_are_none(world) -> None:
    manager = world.get_lightmanager()
    lights = manager.get_all_lights()
    manager.turn_on(lights)
    manager.turn_off(lights)
    manager.set_day_night_cycle(False)
    run(world, 2)


def test_what_is_drawn_is_accepted(world, spots) -> None:
    place, other = spots[0].location, spots[1].location
    world.debug.draw_point(place, life_time=0.1)
    world.debug.draw_line(place, other, life_time=0.1)
    world.debug.draw_arrow(place, other, life_time=0.1)
    world.debug.draw_box(carla.BoundingBox(place, carla.Vector3D(1, 1, 1)), spots[0].rotation, life_time=0.1)
    world.debug.draw_string(place, "here", life_time=0.1)
    run(world, 3)


def test_layers_can_be_loaded_and_unloaded(world) -> None:
    world.unload_map_layer(carla.MapLayer.Buildings)
    world.load_map_layer(carla.MapLayer.Buildings)
    run(world, 2)


def test_there_is_no_navigation_mesh_to_crash_on(world) -> None:
    place = world.get_random_location_from_navigation()
    assert place is None or isinstance(place, carla.Location)
