"""What is measured of a run: contacts, near misses, standing still, and the time to recover."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from stucksolver.evaluate.measure import BLOCKED_S, CollisionWatch, Measures
from stucksolver.scene import EgoState, ObjectKind, Status, TrackedObject

DT = 0.05


def told(time_s: float, speed: float, progress: float, there: bool = False) -> Status:
    return Status(time_s=time_s, speed_mps=speed, progress_m=progress, at_destination=there)


class Trip:
    """A ride of stretches at constant speed, measured tick by tick."""

    def __init__(self, length_m: float = 200.0, start_m: float = 40.0) -> None:
        self.measures = Measures(length_m=length_m, start_m=start_m)
        self.time_s, self.place_m = 7.0, start_m
        self.measures.update(told(self.time_s, 8.0, self.place_m))

    def go(self, seconds: float, speed: float) -> Trip:
        for _ in range(round(seconds / DT)):
            self.time_s += DT
            self.place_m += speed * DT
            self.measures.update(told(self.time_s, speed, self.place_m))
        return self


def test_standing_is_below_0_1_mps_and_the_present_spell_is_known():
    trip = Trip().go(5, 8).go(12, 0).go(3, 8).go(4, 0.05).go(2, 0.2)
    assert trip.measures.standing_s == pytest.approx(16.0, abs=1e-6)
    assert trip.measures.standing_run_s == 0.0
    assert trip.go(6, 0).measures.standing_run_s == pytest.approx(6.0, abs=1e-6)


def test_a_run_is_blocked_after_60_s_of_standing_in_one_spell():
    trip = Trip().go(5, 8).go(59.9, 0)
    assert trip.measures.standing_run_s < BLOCKED_S == 60.0
    assert trip.go(0.2, 0).measures.standing_run_s > BLOCKED_S
    assert Trip().go(40, 0).go(1, 2).go(40, 0).measures.standing_run_s < BLOCKED_S


def test_a_stuck_span_reaches_from_the_onset_to_the_last_tick_of_it():
    trip = Trip().go(5, 8).go(10, 0).go(10, 8)
    assert trip.measures.stuck == [pytest.approx((12.05, 22.0), abs=0.06)]
    assert trip.measures.immobilizations == 1


def test_each_spell_is_a_span_of_its_own():
    spans = Trip().go(5, 8).go(10, 0).go(10, 8).go(6, 0).go(5, 8).measures.stuck
    assert [round(b - a) for a, b in spans] == [10, 6]


def test_a_stop_shorter_than_the_dwell_is_no_immobilization():
    measures = Trip().go(5, 8).go(0.9, 0).go(5, 8).measures
    assert (measures.stuck, measures.immobilizations, measures.recovery_times_s) == ([], 0, [])


def test_the_time_to_recover_is_from_the_onset_to_15_m_of_new_progress():
    measures = Trip().go(5, 8).go(10, 0).go(1.8, 8).measures
    assert measures.recovery_times_s == []
    measures = Trip().go(5, 8).go(10, 0).go(2.0, 8).measures
    assert measures.recovery_times_s == [pytest.approx(10.0 + 15.0 / 8.0, abs=0.11)]


def test_who_creeps_on_and_stands_again_within_15_m_has_one_immobilization():
    measures = Trip().go(5, 8).go(10, 0).go(1, 8).go(10, 0).go(4, 8).measures
    assert measures.immobilizations == 1
    assert measures.recovery_times_s == [pytest.approx(10 + 1 + 10 + 7 / 8, abs=0.11)]


def test_two_recoveries_are_two():
    measures = Trip(length_m=400).go(5, 8).go(10, 0).go(5, 8).go(20, 0).go(5, 8).measures
    assert measures.immobilizations == 2
    assert measures.recovery_times_s == [pytest.approx(11.9, abs=0.11), pytest.approx(21.9, abs=0.11)]


def test_who_never_gets_on_never_recovers():
    measures = Trip().go(5, 8).go(70, 0).measures
    assert (measures.immobilizations, measures.recovery_times_s) == (1, [])


def test_completion_is_the_share_of_the_route_and_100_only_there():
    trip = Trip(length_m=200.0).go(10, 8)
    assert trip.measures.completion_pct == pytest.approx(40.0, abs=0.5)
    trip.measures.update(told(trip.time_s + DT, 3.0, trip.place_m, there=True))
    assert trip.measures.completion_pct == 100.0
    assert Measures(length_m=10.0, start_m=0.0).completion_pct == 0.0


EGO = EgoState(x_m=0, y_m=0, yaw_rad=0, speed_mps=5, length_m=4.8, width_m=2.0)


def other(name: str, y: float, speed: float = 3.0, x: float = 0.0, yaw: float = 0.0) -> TrackedObject:
    return TrackedObject(
        id=name,
        kind=ObjectKind.CAR,
        x_m=x,
        y_m=y,
        yaw_rad=yaw,
        vx_mps=speed * math.cos(yaw),
        vy_mps=speed * math.sin(yaw),
        length_m=4.0,
        width_m=2.0,
        height_m=1.5,
    )


@pytest.mark.parametrize(("gap", "count"), [(0.31, 0), (0.29, 1), (0.0, 1)])
def test_a_near_miss_is_a_gap_below_0_3_m(gap, count):
    measures = Measures(length_m=1, start_m=0)
    news = measures.look(EGO, (other("9", 2.0 + gap),))
    assert measures.near_misses == len(news) == count
    assert all("9" in text for text in news)


def test_a_near_miss_is_to_a_moving_actor():
    measures = Measures(length_m=1, start_m=0)
    assert measures.look(EGO, (other("9", 2.1, speed=0.05),)) == []


def test_a_near_miss_counts_once_while_it_lasts_and_again_after_a_parting():
    measures = Measures(length_m=1, start_m=0)
    for y in (2.1, 2.2, 2.25, 3.0, 2.1):
        measures.look(EGO, (other("9", y), other("8", 5.0)))
    assert measures.near_misses == 2


def test_the_gap_is_between_turned_boxes_not_between_circles():
    measures = Measures(length_m=1, start_m=0)
    assert measures.look(EGO, (other("9", 2.5),)) == []
    assert len(measures.look(EGO, (other("9", 2.5, yaw=math.pi / 2),))) == 1


def watch() -> CollisionWatch:
    """One without a sensor: its events are made here."""
    found = CollisionWatch.__new__(CollisionWatch)
    found._last, found.counts, found.news = {}, {}, []
    return found


def hit(other_id: int, time_s: float, type_id: str = "vehicle.audi.a2") -> SimpleNamespace:
    return SimpleNamespace(other_actor=SimpleNamespace(id=other_id, type_id=type_id), timestamp=time_s)


def test_one_contact_counts_once_however_long_it_lasts():
    seen = watch()
    for tick in range(200):
        seen._hit(hit(4, 10.0 + tick * DT))
    assert seen.counts == {"collision_vehicle": 1}
    assert seen.news == ["collision with vehicle.audi.a2"]


@pytest.mark.parametrize(("pause_s", "count"), [(4.9, 1), (5.1, 2)])
def test_a_contact_after_5_s_without_one_is_another(pause_s, count):
    seen = watch()
    seen._hit(hit(4, 10.0))
    seen._hit(hit(4, 10.0 + pause_s))
    assert seen.counts == {"collision_vehicle": count}


def test_contacts_are_counted_by_whom():
    seen = watch()
    for number, kind in enumerate(("walker.pedestrian.0001", "vehicle.audi.a2", "vehicle.bh.crossbike", "static.wall")):
        seen._hit(hit(number, 3.0, kind))
    assert seen.counts == {"collision_pedestrian": 1, "collision_vehicle": 2, "collision_layout": 1}


def test_a_real_crash_is_one_collision_and_no_callback_comes_after_close():
    carla = pytest.importorskip("carla")
    from stucksolver.evaluate.server import carlette_server

    with carlette_server("demo_town") as server:
        client = carla.Client(server.host, server.port)
        client.set_timeout(15.0)
        world = client.get_world()
        settings = world.get_settings()
        settings.synchronous_mode, settings.fixed_delta_seconds = True, DT
        world.apply_settings(settings)
        library, town = world.get_blueprint_library(), world.get_map()

        def put(s: float):
            transform = town.get_waypoint_xodr(11, -1, s).transform
            transform.location.z += 0.2
            return world.spawn_actor(library.find("vehicle.tesla.model3"), transform)

        ego, _ = put(40.0), put(55.0)
        seen = CollisionWatch(world, ego)
        ego.enable_constant_velocity(carla.Vector3D(6.0, 0.0, 0.0))
        for _ in range(120):
            world.tick()
        assert seen.counts == {"collision_vehicle": 1}
        seen.close()
        for _ in range(20):
            world.tick()
        assert seen.counts == {"collision_vehicle": 1}
