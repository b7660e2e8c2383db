"""The stack on a real client: what it tells the solver, and that it does what the solver says."""

from __future__ import annotations

import math

import numpy as np
import pytest

carla = pytest.importorskip("carla")

from townstage import CAR  # noqa: E402

from stucksolver.plan import CONTINUE, Execute, PathPoint, Replan, SafeStop  # noqa: E402
from stucksolver.plan.behaviors.registry import parse_behavior  # noqa: E402
from stucksolver.scene import LaneDirection, LightState  # noqa: E402
from stucksolver.scene.frenet_scene import FrenetScene  # noqa: E402
from stucksolver_carla.drivers.behavior import BehaviorDriver  # noqa: E402
from stucksolver_carla.stack import CarlaStack  # noqa: E402

pytestmark = pytest.mark.integration

STREET, STREET_END = (11, -1, 40.0), (13, -1, 100.0)
AVENUE, AVENUE_END = (3, -1, 40.0), (3, -1, 400.0)
WAIT = parse_behavior({"name": "wait", "duration_s": 5.0})
KEEP = parse_behavior({"name": "keep_lane", "distance_m": 30.0, "speed_mps": 5.0})


def speed_of(car) -> float:
    velocity = car.get_velocity()
    return math.hypot(velocity.x, velocity.y)


def swerve(stack: CarlaStack, left_m: float, length_m: float = 40.0, speed_mps: float = 5.0) -> Execute:
    """An `Execute` along a path that leaves the route to one side within 15 m."""
    view = FrenetScene(stack.surroundings())
    s = np.arange(0.0, length_m, 1.0)
    x, y, _ = view.frame.to_local(view.ego_s + s, left_m * (1 - np.cos(np.pi * np.clip(s / 15.0, 0, 1))) / 2)
    path = tuple(PathPoint(x_m=float(a), y_m=float(b), speed_mps=speed_mps) for a, b in zip(x, y, strict=True))
    return Execute(behavior=KEEP, path=path)


# ---- told to the solver


def test_progress_reaches_route_length_only_at_destination(stage):
    """Progress grows up to the destination, and no other place counts as the destination."""
    car, stack = stage.ego(STREET, (11, -1, 110.0))
    length_m = stack.route_length_m
    assert length_m == pytest.approx(70.0, abs=1.5)
    told = stage.drive(car, stack, 18.0)
    progress = np.array([status.progress_m for status in told])
    assert (np.diff(progress) >= 0.0).all()
    assert progress[-1] - progress[0] == pytest.approx(length_m, abs=3.0)
    at_end = np.array([status.at_destination for status in told])
    assert at_end[-1] and (np.diff(at_end.astype(int)) >= 0).all()
    first = int(at_end.argmax())
    assert progress[first] - progress[0] == pytest.approx(length_m - 5.0, abs=0.6)
    assert np.diff([status.time_s for status in told]) == pytest.approx(0.05, abs=1e-4)


def test_backing_up_is_no_new_progress(stage):
    car, stack = stage.ego(STREET, STREET_END)
    before = stage.drive(car, stack, 4.0)[-1].progress_m
    car.set_transform(stage.transform((11, -1, 42.0)))
    stage.ticks(2)
    assert stack.status().progress_m == pytest.approx(before, abs=1.5)


def test_status_says_whether_the_driver_drives(stage):
    """Set off on a free street, and stopped at its end."""
    car, stack = stage.ego(STREET, (11, -1, 110.0))
    assert stack.status().drives is None
    told = stage.drive(car, stack, 18.0)
    assert told[10].drives
    assert not told[-1].drives


def test_surroundings_are_in_a_right_handed_local_frame(stage):
    car, stack = stage.ego(STREET, STREET_END)
    ahead, oncoming = stage.add(CAR, (11, -1, 75.0)), stage.add("vehicle.audi.a2", (11, 1, 95.0))
    stage.drive(car, stack, 2.0)
    stack.status()
    around = stack.surroundings()
    transform = car.get_transform()
    assert (around.ego.x_m, around.ego.y_m) == pytest.approx((transform.location.x, -transform.location.y), abs=1e-3)
    assert around.ego.yaw_rad == pytest.approx(-math.radians(transform.rotation.yaw), abs=1e-5)
    assert around.ego.speed_mps == pytest.approx(speed_of(car), abs=0.01) and around.ego.speed_mps > 1.0
    view = FrenetScene(around)
    assert abs(view.ego_d) < 0.2 and abs(view.ego_yaw) < 0.05
    one, other = (view.index_of(str(actor.id)) for actor in (ahead, oncoming))
    assert view.d[one] == pytest.approx(0.0, abs=0.2)
    assert view.d[other] == pytest.approx(3.5, abs=0.2)
    assert view.lane_of[other].strip.direction is LaneDirection.OPPOSITE
    assert abs(view.yaw[other]) == pytest.approx(math.pi, abs=0.05)
    gap = ahead.get_location().distance(car.get_location())
    assert view.s[one] - view.ego_s == pytest.approx(gap, abs=0.3)
    assert around.frame == stage.world.get_snapshot().frame


def test_the_ego_s_place_on_the_road_is_its_progress(stage):
    car, stack = stage.ego(STREET, STREET_END)
    apart = []
    for _ in range(4):
        stage.drive(car, stack, 2.0)
        apart.append(stack.status().progress_m - FrenetScene(stack.surroundings()).ego_s)
    assert apart == pytest.approx([apart[0]] * 4, abs=0.1)
    assert stack.status().progress_m > 30.0


def test_the_road_is_fetched_once_for_an_episode(stage):
    car, stack = stage.ego(AVENUE, AVENUE_END)
    stack.status()
    first = stack.surroundings().road
    stage.drive(car, stack, 4.0)
    stack.status()
    assert stack.surroundings().road is first
    car.set_transform(stage.transform((3, -1, 70.0)))
    for s in range(80, 125, 15):
        car.set_transform(stage.transform((3, -1, float(s))))
        stage.ticks(1)
        stack.status()
    later = stack.surroundings().road
    assert later.key != first.key and later.route_start_m > first.route_start_m


def test_sight_is_blocked_by_fire_truck_and_not_by_car(stage):
    """A parked fire truck occludes the road; a parked car does not."""
    _, stack = stage.ego(STREET, STREET_END)
    parked = stage.add(CAR, (11, -1, 65.0))
    stage.ticks(12)
    stack.status()
    free = {item.lane_id: item.ahead_m for item in stack.surroundings().sight}
    parked.destroy()
    stage.actors.remove(parked)
    stage.add("vehicle.carlamotors.firetruck", (11, -1, 65.0))
    stage.ticks(12)
    stack.status()
    hidden = {item.lane_id: item.ahead_m for item in stack.surroundings().sight}
    own = next(name for name in free if name.startswith("own"))
    assert free[own] > 150.0 and hidden[own] < 30.0


def test_sight_is_of_the_same_tick_as_the_objects(stage):
    """The guard asks whether a sight ends at an object: both must be where they are now."""
    _, stack = stage.ego(STREET, STREET_END)
    stage.ticks(12)
    stack.status()
    free = {item.lane_id: item.ahead_m for item in stack.surroundings().sight}
    engine = stage.add("vehicle.carlamotors.firetruck", (11, -1, 65.0))
    stage.ticks(2)
    stack.status()
    around = stack.surroundings()
    assert any(obj.id == str(engine.id) for obj in around.objects)
    hidden = {item.lane_id: item.ahead_m for item in around.sight}
    own = next(name for name in free if name.startswith("own"))
    assert free[own] > 150.0 and hidden[own] < 30.0


def test_a_light_ahead_is_told_from_the_front_bumper(stage):
    light = stage.light(11)
    light.set_state(carla.TrafficLightState.Red)
    light.freeze(True)
    car, stack = stage.ego((11, 1, 60.0), (21, -1, 60.0))
    stack.status()
    (control,) = stack.surroundings().controls
    (line,) = light.get_stop_waypoints()
    gap = line.transform.location.distance(car.get_location()) - car.bounding_box.extent.x
    assert control.state is LightState.RED
    assert control.distance_m == pytest.approx(gap, abs=0.3)


def test_scene_has_objects_ahead_and_candidate_waypoints(stage):
    """The scene names the objects ahead and the places where the route may begin anew."""
    car, stack = stage.ego(AVENUE, AVENUE_END)
    ahead = stage.add(CAR, (3, -1, 70.0), role="scenario")
    stage.drive(car, stack, 0.5)
    scene = stack.scene()
    (told,) = [o for o in scene.objects if o.id == str(ahead.id)]
    assert told.x_m == pytest.approx(ahead.get_location().distance(car.get_location()), abs=0.5)
    assert told.y_m == pytest.approx(0.0, abs=0.3)
    assert "scenario" not in scene.model_dump_json()
    lanes = {w.lane_id.split("@")[0] for w in scene.waypoints}
    assert lanes == {"own", "right1-driving", "back-elsewhere0"}
    for waypoint in scene.waypoints:
        if waypoint.lane_id.startswith("back"):
            assert waypoint.x_m < 0.0 < waypoint.y_m  # in the other direction's lane, for a vehicle that turned round
            continue
        assert waypoint.x_m == pytest.approx(waypoint.distance_m, abs=1.0)
        assert waypoint.y_m == pytest.approx(-3.5 if waypoint.lane_id.startswith("right") else 0.0, abs=0.3)


# ---- done for the solver


def test_continue_drives_the_route(stage):
    car, stack = stage.ego(STREET, STREET_END)
    stage.drive(car, stack, 5.0, CONTINUE)
    assert speed_of(car) > 5.0
    assert abs(FrenetScene(stack.surroundings()).ego_d) < 0.2


@pytest.mark.parametrize("left_m", [1.5, -1.0])
def test_execute_drives_the_given_path_within_its_speed(stage, left_m):
    car, stack = stage.ego(STREET, STREET_END)
    stage.drive(car, stack, 2.0)
    told = stage.drive(car, stack, 5.0, swerve(stack, left_m))
    assert FrenetScene(stack.surroundings()).ego_d == pytest.approx(left_m, abs=0.15)
    assert max(status.speed_mps for status in told[20:]) < 5.3
    stage.drive(car, stack, 8.0, CONTINUE)
    assert abs(FrenetScene(stack.surroundings()).ego_d) < 0.3


def test_the_same_directive_is_begun_once(stage):
    class Counting(BehaviorDriver):
        begun = 0

        def follow(self, path, reverse=False):
            self.begun += 1
            super().follow(path, reverse)

    car = stage.add(CAR, STREET)
    stage.ticks(2)
    driver = Counting(car, carla_map=stage.map)
    driver.set_destination(stage.map.get_waypoint_xodr(*STREET_END).transform.location)
    stack = CarlaStack(car, driver, stage.map)
    stack.status()
    directive = swerve(stack, 1.0)
    stage.drive(car, stack, 1.0, directive)
    assert driver.begun == 1
    stage.drive(car, stack, 0.5, directive.model_copy())
    assert driver.begun == 2


def test_execute_without_a_path_holds_until_released(stage):
    car, stack = stage.ego(STREET, STREET_END)
    stage.drive(car, stack, 3.0)
    stage.drive(car, stack, 4.0, Execute(behavior=WAIT))
    place = car.get_location()
    assert speed_of(car) < 0.05
    stage.drive(car, stack, 2.0, Execute(behavior=WAIT))
    assert car.get_location().distance(place) < 0.05
    stage.drive(car, stack, 3.0, CONTINUE)
    assert car.get_location().distance(place) > 3.0


def test_a_replan_keeps_the_destination_and_the_progress(stage):
    car, stack = stage.ego(AVENUE, AVENUE_END)
    before = stage.drive(car, stack, 4.0)[-1]
    left = stack.route_length_m
    told = stage.drive(car, stack, 3.0, Replan())
    assert told[0].progress_m >= before.progress_m
    progress = [status.progress_m for status in told]
    assert (np.diff(progress) >= 0.0).all()
    assert progress[-1] - before.progress_m < 40.0
    assert stack.route_length_m == pytest.approx(left - (progress[-1] - before.progress_m), abs=2.5)


def test_a_replan_may_begin_in_the_lane_beside(stage):
    car, stack = stage.ego(AVENUE, AVENUE_END)
    told = stage.drive(car, stack, 2.0)
    scene = stack.scene()
    (start,) = [w for w in scene.waypoints if w.lane_id.startswith("right1") and w.distance_m == 40.0]
    ahead = scene_place(car, start)
    told += stage.drive(car, stack, 8.0, Replan(route_start=start.id))
    first = stage.driver.route[0].waypoint
    assert (first.road_id, first.lane_id) == (3, -2)
    assert first.transform.location.distance(ahead) < 0.5
    assert (np.diff([status.progress_m for status in told]) >= 0.0).all()
    assert speed_of(car) > 3.0


@pytest.mark.parametrize("left_m", [30.0, 4.0, -6.0])
def test_replan_beside_destination_does_not_circle_block(stage, left_m):
    """A replan beside the destination does not lead around the town.

    From the adjacent lane, next to the destination, the only route to it leads once around the block.
    """
    end = (3, -1, 140.0)
    car, stack = stage.ego(AVENUE, end)
    stage.drive(car, stack, 1.0)
    car.set_transform(stage.transform((3, -2, end[2] - left_m - 60.0)))
    stage.ticks(2)
    stack.status()
    (start,) = [w for w in stack.scene().waypoints if w.lane_id.startswith("right1") and w.distance_m == 70.0]
    for s in np.linspace(end[2] - left_m - 60.0, end[2] - left_m, 12):
        car.set_transform(stage.transform((3, -2, float(s))))
        stage.ticks(1)
        stack.status()
    before = len(stage.driver.route)
    stage.drive(car, stack, 0.5, Replan(route_start=start.id))
    assert len(stage.driver.route) <= before
    goal = stage.map.get_waypoint_xodr(*end).transform.location
    assert stage.driver.route[-1].waypoint.transform.location.distance(goal) < 4.0


def test_replan_near_destination_ends_alongside_it(stage):
    """A route from the adjacent lane ends alongside a destination that is too near to change back."""
    end = (3, -1, 140.0)
    car, stack = stage.ego(AVENUE, end)
    stage.drive(car, stack, 1.0)
    car.set_transform(stage.transform((3, -2, 115.0)))
    stage.ticks(2)
    stack.status()
    (start,) = [w for w in stack.scene().waypoints if w.lane_id.startswith("right1") and w.distance_m == 20.0]
    told = stage.drive(car, stack, 10.0, Replan(route_start=start.id))
    last = stage.driver.route[-1].waypoint
    assert (last.road_id, last.lane_id) == (3, -2)
    assert last.s == pytest.approx(140.0, abs=1.0)
    assert told[-1].at_destination


def scene_place(car, waypoint):
    """A place of the scene in CARLA's world: y to the left becomes y to the right."""
    return car.get_transform().transform(carla.Location(waypoint.x_m, -waypoint.y_m, 0.0))


def test_a_replan_from_an_unknown_place_begins_here(stage):
    car, stack = stage.ego(STREET, STREET_END)
    stage.drive(car, stack, 2.0)
    stage.drive(car, stack, 2.0, Replan(route_start="nowhere"))
    assert speed_of(car) > 3.0


def test_safe_stop_hazard_lights_end_when_drive_continues(stage):
    """A safe stop switches on hazard lights, which go out when the drive continues."""
    car, stack = stage.ego(STREET, STREET_END)
    stage.drive(car, stack, 3.0)
    stage.drive(car, stack, 4.0, SafeStop(reason="nothing more can be done"))
    lights = int(car.get_light_state())
    assert speed_of(car) < 0.05
    assert lights & 48 == 48
    stage.drive(car, stack, 3.0, CONTINUE)
    assert speed_of(car) > 1.0
    assert int(car.get_light_state()) & 48 == 0
