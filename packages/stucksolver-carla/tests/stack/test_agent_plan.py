"""At the end of its route every copy of BehaviorAgent drives on until whoever runs it ends the drive; none fails."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace

import pytest

carla = pytest.importorskip("carla")

from agents_package import WHERE, agents_folders, behavior_agent_class  # noqa: E402
from fake_agents import EarlyAgent, FakeAgent, RoadOption  # noqa: E402
from townstage import CAR  # noqa: E402

from stucksolver_bridge import AgentDriver  # noqa: E402
from stucksolver_bridge.agent_plan import AgentsError, PlanExtender, make_agent, plan_of  # noqa: E402

pytestmark = pytest.mark.integration

START, END = (11, -1, 20.0), (11, -1, 70.0)
BEYOND_M = 40.0
"""Of the route's end, on the same road; no evaluator waits for longer."""

AGENTS = [pytest.param(lambda: FakeAgent, id="fake"), pytest.param(lambda: EarlyAgent, id="fake-early")]
AGENTS += [pytest.param(lambda f=folder: behavior_agent_class(f), id=Path(folder).name) for folder in agents_folders()]
if not agents_folders():
    AGENTS.append(pytest.param(None, id="public", marks=pytest.mark.skip(reason=WHERE)))


def leaderboard_plan(stage, agent, start=START, end=END):
    """Waypoints a meter apart and the agents' own road options, as the evaluator hands them over."""
    road, lane, first = start
    follow = type(agent.get_local_planner().target_road_option).LANEFOLLOW
    spots = [first + meter for meter in range(int(end[2] - first) + 1)]
    return [(stage.map.get_waypoint_xodr(road, lane, s), follow) for s in spots]


def driver_on(stage, agent_class, start=START, end=END, keeps_going=True):
    car = stage.add(CAR, start, role="hero")
    stage.ticks(2)
    agent = make_agent(agent_class, car, "normal", stage.map)
    driver = AgentDriver(agent, carla, keeps_going=keeps_going)
    driver.set_plan(leaderboard_plan(stage, agent, start, end))
    return car, driver


def drive(stage, car, driver, seconds, until=lambda: False):
    for _ in range(round(seconds * 20)):
        car.apply_control(driver.run_step())
        stage.world.tick()
        if until():
            return True
    return False


def beyond_m(stage, car, place=END):
    goal, here = stage.transform(place), car.get_location()
    along = goal.get_forward_vector()
    return (here.x - goal.location.x) * along.x + (here.y - goal.location.y) * along.y


@pytest.mark.parametrize("agent_class", AGENTS)
def test_it_rolls_on_along_the_lane_at_its_speed(stage, agent_class):
    car, driver = driver_on(stage, agent_class())
    assert drive(stage, car, driver, 30.0, lambda: beyond_m(stage, car) > 0.0)
    at_the_end = car.get_velocity().length()
    assert drive(stage, car, driver, 20.0, lambda: beyond_m(stage, car) > BEYOND_M)
    assert car.get_velocity().length() > 0.7 * at_the_end
    lane = stage.map.get_waypoint(car.get_location())
    assert (lane.road_id, lane.lane_id) == END[:2]
    assert lane.transform.location.distance(car.get_location()) < 1.0


@pytest.mark.parametrize("agent_class", AGENTS)
def test_agent_keeps_going_drives_unchanged_to_last_waypoint(stage, agent_class):
    """Up to its last waypoint, the agent drives as it does without the extension of its route."""
    trails = []
    for keeps_going in (False, True):
        car, driver = driver_on(stage, agent_class(), keeps_going=keeps_going)
        trail = []
        while beyond_m(stage, car) < -3.0 and len(trail) < 400:
            control = driver.run_step()
            trail.append((round(control.steer, 6), round(control.throttle, 6), round(control.brake, 6)))
            car.apply_control(control)
            stage.world.tick()
        trails.append(trail)
        stage.clear()
    assert 50 < len(trails[0]) < 400
    assert trails[0] == trails[1]


@pytest.mark.parametrize("agent_class", AGENTS)
def test_handed_back_past_the_end_it_drives_on_too(stage, agent_class):
    car, driver = driver_on(stage, agent_class())
    ahead = [stage.map.get_waypoint_xodr(*END[:2], s).transform.location for s in range(30, 80)]
    driver.follow([(place.x, place.y, 6.0) for place in ahead])
    assert drive(stage, car, driver, 30.0, lambda: beyond_m(stage, car) > 6.0)
    driver.release()
    assert drive(stage, car, driver, 20.0, lambda: beyond_m(stage, car) > BEYOND_M)


@pytest.mark.parametrize("agent_class", AGENTS)
def test_agent_forgotten_route_is_driven(stage, agent_class):
    """The part of its route that the agent dropped is driven nevertheless.

    CARLA's agent plans anew to the next waypoint only when it changes lanes before a tailgater.
    """
    car, driver = driver_on(stage, agent_class())
    drive(stage, car, driver, 2.0)
    planner = driver.agent.get_local_planner()
    planner.set_global_plan(plan_of(planner)[:6], stop_waypoint_creation=True, clean_queue=True)
    assert drive(stage, car, driver, 10.0, lambda: len(plan_of(planner)) > 6)
    goal = stage.transform(END).location
    assert min(waypoint.transform.location.distance(goal) for waypoint, _ in plan_of(planner)) < 0.5


def test_agent_plan_beginning_ahead_is_reached_along_lane(stage):
    """A plan that begins ahead is reached along the lane.

    It may change lanes where it begins, and the agent looks for obstacles in the lane of its next waypoints.
    """
    start, lane, beside = (3, -2, 40.0), (3, -2), (3, -1)
    car, driver = driver_on(stage, FakeAgent, start, (3, -2, 60.0))
    planner = driver.agent.get_local_planner()
    onward = [(stage.map.get_waypoint_xodr(*beside, s), "change_left") for s in range(76, 120)]
    driver.set_plan([(stage.map.get_waypoint_xodr(*lane, 75.0), "lane_follow"), *onward])
    here = car.get_location()
    ahead = [waypoint for waypoint, _ in plan_of(planner) if waypoint.transform.location.distance(here) < 34.0]
    assert len(ahead) > 25
    assert {(waypoint.road_id, waypoint.lane_id) for waypoint in ahead} == {lane}
    driver.set_plan(onward)
    assert len(plan_of(planner)) == len(onward), "from the lane beside nothing leads there along the lane"


def test_at_a_fork_it_goes_straight_on(stage):
    start, end = (25, -1, 95.0), (25, -1, 135.0)
    ways = stage.map.get_waypoint_xodr(*end).next(20.0)
    assert len(ways) > 1, "the test needs a fork"
    stage.light(25).set_state(carla.TrafficLightState.Green)
    stage.light(25).freeze(True)
    car, driver = driver_on(stage, FakeAgent, start, end)
    before = car.get_transform().rotation.yaw
    assert drive(stage, car, driver, 40.0, lambda: beyond_m(stage, car, end) > 35.0)
    assert abs(math.remainder(car.get_transform().rotation.yaw - before, 360.0)) < 20.0


def test_where_the_lane_ends_there_is_nothing_to_add(stage):
    car, driver = driver_on(stage, FakeAgent)
    last = SimpleNamespace(transform=stage.transform((11, -1, 22.0)), is_junction=False, next=lambda _distance: [])
    planner = driver.agent.get_local_planner()
    driver.set_plan([(last, RoadOption.LANEFOLLOW)] * 2)
    carla_map = SimpleNamespace(get_waypoint=lambda _location: last)
    driver._plan_extender = PlanExtender(planner, car, carla_map, RoadOption.LANEFOLLOW)
    drive(stage, car, driver, 10.0)
    assert plan_of(planner) == []
    assert car.get_velocity().length() < 0.2


def test_agent_without_extension_stops_at_end_of_route(stage):
    """An agent whose route is not extended stops at its end."""
    car = stage.add(CAR, START, role="hero")
    stage.ticks(2)
    agent = FakeAgent(car)
    driver = AgentDriver(agent, carla)
    driver.set_plan(leaderboard_plan(stage, agent))
    drive(stage, car, driver, 30.0)
    assert car.get_velocity().length() < 0.2
    assert abs(beyond_m(stage, car)) < 8.0
    assert driver.done()


def test_a_copy_that_is_too_old_is_refused_by_name(stage):
    class OldAgent:
        def __init__(self, vehicle, behavior="normal", ignore_traffic_light=False):
            """As in 0.9.11."""

    with pytest.raises(AgentsError, match=r"test_agent_plan\.py has no get_local_planner; use .* 0\.9\.12"):
        make_agent(OldAgent, None, "normal", None)
