"""Who comes into the hero's lane, comes up behind it, or disturbs it."""

from __future__ import annotations

import math

import pytest

carla = pytest.importorskip("carla")

pytestmark = pytest.mark.integration


def value(number):
    return {"value": str(number)}


def test_static_cut_in_car_leaves_queue_into_ego_lane(play):
    """One car of the queue pulls out into the ego's lane, and the others remain stopped."""
    playing = play("StaticCutIn_1", traffic=False, distance=value(41))
    assert not playing.others()
    playing.jump(5.0)
    playing.run(0.5)
    queue = playing.others()
    places = [playing.along(item) for item in queue]
    assert [round(s_m - places[0][0]) for s_m, _ in places] == [0, 11, 22, 33, 44, 55]
    assert all(2.5 < abs(right_m) < 4.5 for _, right_m in places)
    cutter = queue[2]
    playing.jump(places[2][0] - 14.0)
    playing.run(5.0)
    s_m, right_m = playing.along(cutter)
    assert abs(right_m) < 0.6 and playing.facing_deg(cutter) < 6.0 and s_m > places[2][0] + 5.0
    assert all(playing.cast.state(item).speed_mps < 0.1 for item in queue if item is not cutter)
    assert playing.run(12.0, lambda: playing.play.finished) and not playing.others()


def test_a_parked_car_pulls_out_in_front_of_the_hero(play):
    playing = play("ParkingCutIn_1", traffic=False)
    blocker, cutter = playing.others()
    playing.jump(5.0)
    assert [round(playing.along(item)[0] - 5.0) for item in (blocker, cutter)] == [28, 35]
    assert abs(playing.along(cutter)[1]) > 2.5
    playing.jump(5.0 + 35.0 - 11.5)
    playing.run(1.0)
    assert playing.cast.state(cutter).speed_mps < 0.1
    playing.jump(5.0 + 35.0 - 9.0)
    playing.run(4.0)
    assert abs(playing.along(cutter)[1]) < 0.6
    assert playing.run(6.0, lambda: playing.play.finished) and not playing.others()


def test_highway_cut_in_car_merges_from_ramp_near_ego(play):
    """A car comes down the ramp together with the ego and cuts in less than 15 m from it."""
    playing = play("HighwayCutIn_1", traffic=False)
    playing.go(15.0)
    playing.run(1.0)
    (car,) = playing.others()
    abreast = math.inf
    ended_in_lane = False
    for _ in range(600):
        playing.tick()
        if playing.play.finished:
            break
        if not playing.others():
            continue
        s_m, right_m = playing.along(car)
        if right_m > 2.0:
            abreast = abs(s_m - playing.hero_s)
        ended_in_lane = abs(right_m) < 1.0
    assert playing.play.finished
    assert abreast < 15.0 and ended_in_lane


def test_emergency_vehicle_behind_blocking_ego_scores_zero(play):
    """An emergency vehicle closes in and waits behind an ego that does not yield; the event has value 0."""
    playing = play("YieldToEmergencyVehicle_1", traffic=False, before_m=40.0)
    playing.go(12.0)
    playing.run(5.0, lambda: bool(playing.play.active))
    playing.run(1.0)
    (vehicle,) = playing.others()
    fastest = 0.0
    for _ in range(320):
        playing.tick()
        if playing.play.finished:
            break
        fastest = max(fastest, playing.cast.state(vehicle).speed_mps)
    # Ahead of it all the time: it closed in, and waits behind.
    assert fastest > 15.0
    (event,) = [item for item in playing.play.events if item.kind == "yield_emergency_vehicle"]
    assert event.value == 0.0


def test_emergency_vehicle_passes_ego_that_left_lane(play):
    """The emergency vehicle passes an ego that has left its lane; the event has value 1."""
    playing = play("YieldToEmergencyVehicle_1", traffic=False)
    playing.jump(5.0)
    place = playing.route.waypoint_at(playing.hero_s)
    beside = next(
        lane
        for lane in (place.get_left_lane(), place.get_right_lane())
        if lane is not None and lane.lane_type == carla.LaneType.Driving
    )
    transform = beside.transform
    transform.location.z += 0.2
    playing.hero.set_transform(transform)
    playing.run(15.0, lambda: playing.play.finished)
    (event,) = [item for item in playing.play.events if item.kind == "yield_emergency_vehicle"]
    assert event.value == 1.0


def test_debris_disturbs_the_hero_only_while_it_is_near(play):
    playing = play("ControlLoss_1", traffic=False)
    wish = carla.VehicleControl(throttle=0.5)
    disturbed = []
    for distance_m in (0.0, 8.0, 14.0, 20.0, 48.0, 60.0, 74.0):
        playing.jump(5.0 + distance_m)
        noisy = playing.play.noise(wish)
        disturbed.append(abs(noisy.steer) > 0.0)
        if disturbed[-1]:
            assert 0.0 < abs(noisy.steer) < 0.12 and 0.0 < abs(noisy.throttle - 0.5) < 0.08
    assert disturbed == [False, False, True, False, True, False, True]


def test_parking_exit_ego_starts_between_parked_cars(play):
    """The ego starts between two parked cars, and a third car next to it drives away."""
    playing = play("ParkingExit_1", traffic=False, before_m=0.0)
    playing.tick()
    front, behind, side = playing.others()
    hero = playing.cast.hero
    assert abs(_right_m(playing)) > 2.0
    assert hero.ahead_m(*_xy(playing, front)) == pytest.approx(9.0, abs=0.5)
    assert hero.ahead_m(*_xy(playing, behind)) == pytest.approx(-9.0, abs=0.5)
    assert playing.apart_m(side) < 4.0
    playing.run(7.0)
    assert side not in playing.others() or playing.apart_m(side) > 30.0
    assert not playing.play.finished
    playing.jump(playing.hero_s + 25.0)
    assert playing.play.finished


def _xy(playing, member):
    state = playing.cast.state(member)
    return state.x, state.y


def _right_m(playing):
    return playing.along(playing.cast.hero_member)[1]
