"""Loading worlds: what a new episode keeps and what it does not."""

from __future__ import annotations

import pytest
from stage import DT, make_synchronous, run, soon, spawn

from straight import straight_road

carla = pytest.importorskip("carla")


@pytest.fixture
def town(world):
    """The name of the town, to load it again."""
    return world.get_map().name.rsplit("/", 1)[-1]


@pytest.fixture
def back(client, town):
    """Loads the town again after a test that left it."""
    yield
    client.load_world(town)


def test_the_server_has_the_clients_version(client) -> None:
    assert client.get_server_version() == client.get_client_version()


def test_the_current_map_is_among_the_available_ones(client, town) -> None:
    assert town in {item.rsplit("/", 1)[-1] for item in client.get_available_maps()}


def test_new_episode_on_same_town_has_new_id(client, world, town) -> None:
    """A new episode has a new id, even on the same town."""
    assert client.load_world(town).id != world.id


def test_a_new_episode_has_no_actors_of_the_old_one(client, world, town, spots) -> None:
    car = spawn(world, spots[0])
    fresh = client.load_world(town, False)
    fresh.tick()
    assert not fresh.get_actors().filter("vehicle.*")
    assert not car.is_alive


def test_a_new_episode_has_the_lights_of_the_town_again(client, world, town) -> None:
    def signs(of):
        return sorted(item.get_opendrive_id() for item in of.get_actors().filter("*traffic_light*"))

    before = signs(world)
    fresh = client.load_world(town, False)
    fresh.tick()
    assert signs(fresh) == before
    assert len(set(before)) == len(before)


def test_settings_are_kept_when_asked_for(client, world, town) -> None:
    settings = world.get_settings()
    settings.deterministic_ragdolls = True
    settings.tile_stream_distance, settings.actor_active_distance = 650.0, 640.0
    world.apply_settings(settings)
    kept = client.load_world(town, False).get_settings()
    assert (kept.synchronous_mode, kept.fixed_delta_seconds) == (True, DT)
    assert (kept.tile_stream_distance, kept.actor_active_distance) == (650.0, 640.0)


def test_settings_are_those_of_the_start_otherwise(client, world, town) -> None:
    settings = world.get_settings()
    settings.no_rendering_mode = True
    world.apply_settings(settings)
    assert not client.load_world(town, True).get_settings().synchronous_mode
    make_synchronous(client.get_world())
    reset = client.reload_world().get_settings()
    assert not reset.synchronous_mode
    assert not reset.no_rendering_mode


def test_frames_go_on_and_ticks_work_at_once(client, world, town) -> None:
    frame = world.tick()
    fresh = client.load_world(town, False)
    assert fresh.tick() > frame


def test_a_map_that_is_loaded_already_is_not_loaded_again(client, world, town) -> None:
    client.load_world_if_different(town)
    assert client.get_world().id == world.id


def test_many_worlds_one_after_the_other(client, world, town) -> None:
    ids = {client.load_world(town, False).id for _ in range(8)}
    assert len(ids) == 8


def test_another_client_finds_itself_in_the_new_episode(client, new_client, world, town, spots) -> None:
    other = new_client()
    its_car = spawn(other.get_world(), spots[0])
    fresh = client.load_world(town, False)
    assert soon(lambda: other.get_world().id == fresh.id)
    assert not its_car.is_alive
    assert other.get_world().get_map().get_spawn_points()
    assert spawn(other.get_world(), spots[0]).is_alive


def test_load_world_unknown_town_is_named_in_error(client, world) -> None:
    """The error for an unknown town names it, and the world continues."""
    with pytest.raises(RuntimeError, match=r"(?i)Atlantis"):
        client.load_world("Atlantis")
    run(world, 2)


@pytest.mark.parametrize("reset", [True, False])
def test_a_world_can_be_made_of_an_opendrive_text(client, world, back, reset: bool) -> None:
    parameters = carla.OpendriveGenerationParameters(
        vertex_distance=2.0,
        max_road_length=50.0,
        wall_height=1.0,
        additional_width=0.6,
        smooth_junctions=True,
        enable_mesh_visibility=True,
        enable_pedestrian_navigation=False,
    )
    made = client.generate_opendrive_world(straight_road(), parameters, reset)
    assert made.id != world.id
    assert made.get_map().name.endswith("OpenDriveMap")
    assert made.get_map().get_topology()
    assert made.get_settings().synchronous_mode is not reset


@pytest.mark.carlette_only
def test_a_client_sees_the_map_that_another_made(client, new_client, world, back) -> None:
    other = new_client()
    before = other.get_world().get_map().name
    client.generate_opendrive_world(straight_road())
    assert soon(lambda: other.get_world().get_map().name != before)


@pytest.mark.carlette_only
def test_a_made_world_can_be_loaded_again_by_its_name(client, world, back, town) -> None:
    client.generate_opendrive_world(straight_road())
    client.load_world(town)
    assert client.load_world("OpenDriveMap").get_map().get_waypoint_xodr(7, -1, 100.0)


@pytest.mark.carlette_only
@pytest.mark.parametrize(("text", "reason"), [("<nonsense", "XML"), ("", "empty"), ("<OpenDRIVE/>", "driving")])
def test_opendrive_invalid_text_is_rejected_and_world_stays(client, world, text: str, reason: str) -> None:
    """A text that is not a map is rejected with a reason, and the present world stays."""
    with pytest.raises(RuntimeError, match=reason):
        client.generate_opendrive_world(text)
    assert client.get_world().id == world.id
    run(world, 2)


def test_actor_ids_are_never_reused_across_episodes(client, world, town) -> None:
    """Actor ids are never reused, so that a client does not take one actor for another."""
    world.tick()
    before = {actor.id for actor in world.get_actors()}
    fresh = client.load_world(town, False)
    fresh.tick()
    after = list(fresh.get_actors())
    assert not before & {actor.id for actor in after}
    assert len(after) == len(before)
