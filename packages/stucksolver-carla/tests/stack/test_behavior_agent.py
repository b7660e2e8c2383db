"""CARLA's own BehaviorAgent: helped, it gets past what it would stand behind for ever; alone, it is as it was."""

from __future__ import annotations

import pytest

carla = pytest.importorskip("carla")

from agents_package import behavior_agent_class  # noqa: E402
from townstage import CAR  # noqa: E402

import stucksolver_carla  # noqa: E402
from stucksolver_bridge.agent_plan import make_agent  # noqa: E402

pytestmark = pytest.mark.integration

STREET, STREET_END = (11, -1, 20.0), (13, -1, 100.0)
CONE = "static.prop.constructioncone"


def agent_on(stage, start=STREET, end=STREET_END):
    """A car driven by BehaviorAgent, with a plan."""
    agent_class = behavior_agent_class()
    car = stage.add(CAR, start, role="hero")
    stage.ticks(2)
    agent = make_agent(agent_class, car, "normal", stage.map)
    agent.set_destination(stage.map.get_waypoint_xodr(*end).transform.location)
    return car, agent


def put(stage, blueprint, place, aside_m=0.3):
    """Something that stands a little beside the middle: what is at an angle of exactly 0, the agent does not see."""
    thing = stage.add(blueprint, place)
    where = stage.transform(place)
    right = where.get_right_vector()
    where.location.x, where.location.y = where.location.x + aside_m * right.x, where.location.y + aside_m * right.y
    thing.set_transform(where)
    return thing


def collisions_of(stage, car):
    """A list that fills with what the car runs into."""
    found = []
    sensor = stage.world.spawn_actor(
        stage.world.get_blueprint_library().find("sensor.other.collision"), carla.Transform(), attach_to=car
    )
    sensor.listen(lambda event: found.append(event.other_actor.type_id))
    stage.actors.insert(0, sensor)
    return found


def run(stage, car, agent, seconds, until=lambda: False):
    """Lets it drive; True when what was waited for came."""
    for _ in range(round(seconds * 20)):
        car.apply_control(agent.run_step())
        stage.world.tick()
        if until():
            return True
    return False


def past(stage, car, place, by_m=15.0):
    """Is the car this far past a place of the street?"""
    goal = stage.transform(place)
    along = goal.get_forward_vector()

    def there():
        here = car.get_location()
        return (here.x - goal.location.x) * along.x + (here.y - goal.location.y) * along.y > by_m

    return there


def test_agent_passes_parked_car_only_with_solver(stage):
    """Alone, the agent stays behind a parked car; with the solver, it passes."""
    parked = (11, -1, 60.0)
    put(stage, CAR, parked)
    car, agent = agent_on(stage)
    assert not run(stage, car, agent, 20.0, past(stage, car, parked))
    events = []
    helped = stucksolver_carla.attach(agent, ladder="evaluation", clock="lockstep", on_event=events.append)
    bumps = collisions_of(stage, car)
    came = run(stage, car, helped, 60.0, past(stage, car, parked))
    helped.close()
    assert came, "\n".join(f"{e.time_s:.1f} {e.kind.value} {e.text}" for e in events)
    assert not bumps


def helped_past(stage, place, seconds=70.0, **options):
    """Drives helped past a place; whether it came, what it ran into, and what was done."""
    car, agent = agent_on(stage)
    bumps, events = collisions_of(stage, car), []
    helped = stucksolver_carla.attach(agent, ladder="evaluation", clock="lockstep", on_event=events.append, **options)
    came = run(stage, car, helped, seconds, past(stage, car, place))
    helped.close()
    return came, bumps, [f"{e.time_s:.1f} {e.kind.value} {e.text}" for e in events]


def cones_across(stage, s=60.0):
    for ahead, aside in ((0.0, 0.9), (2.5, 0.5), (5.0, 0.1), (7.5, 0.1), (10.0, 0.5)):
        put(stage, CONE, (11, -1, s + ahead), aside)


def test_agent_gets_perceived_cones_as_obstacles(stage):
    """The agent does not perceive cones; perceived ones are added to its obstacles."""
    cones_across(stage)
    came, bumps, _ = helped_past(stage, (11, -1, 70.0), obstacles=False)
    assert came and bumps
    stage.clear()
    cones_across(stage)
    came, bumps, told = helped_past(stage, (11, -1, 70.0))
    assert came, "\n".join(told)
    assert not bumps, told


def test_it_passes_two_cyclists_who_have_stopped(stage):
    for ahead in (0.0, 9.0):
        put(stage, "vehicle.diamondback.century", (11, -1, 60.0 + ahead), 0.96)
    came, bumps, told = helped_past(stage, (11, -1, 69.0))
    assert came, "\n".join(told)
    assert not bumps, told


def test_on_a_free_road_it_drives_exactly_as_without_us(stage):
    trails = []
    for helped in (False, True):
        car, agent = agent_on(stage)
        driver = stucksolver_carla.attach(agent, clock="lockstep") if helped else agent
        trail = []
        for _ in range(240):
            control = driver.run_step()
            car.apply_control(control)
            stage.world.tick()
            trail.append((round(control.steer, 6), round(control.throttle, 6), round(control.brake, 6)))
        trails.append(trail)
        stage.clear()
    assert trails[0] == trails[1]


def test_a_new_destination_is_driven_to_and_done(stage):
    car, agent = agent_on(stage)
    helped = stucksolver_carla.attach(agent, clock="lockstep")
    assert not helped.done()
    run(stage, car, helped, 2.0)
    goal = stage.map.get_waypoint_xodr(11, -1, 90.0).transform.location
    helped.set_destination(goal)
    assert run(stage, car, helped, 30.0, helped.done)
    assert car.get_location().distance(goal) < 8.0
