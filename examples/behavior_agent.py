"""CARLA's BehaviorAgent with StuckSolver, on a street with a car parked in its lane.

Needs a running server (carlette or CARLA), and CARLA's `agents` package on the path:
python examples/behavior_agent.py [HOST PORT]
The exit status is 0 if the vehicle arrived, else 1.
"""

from __future__ import annotations

import socket
import sys

try:
    import carla
except ModuleNotFoundError:
    sys.exit("the carla package is not installed: pip install 'carla>=0.9.15'")
try:
    from agents.navigation.behavior_agent import BehaviorAgent
except ModuleNotFoundError as error:
    sys.exit(f"no module {error.name!r}: it comes with CARLA; add its folder PythonAPI/carla to PYTHONPATH")

import stucksolver_carla
from stucksolver.solver import Event
from stucksolver_bridge.agent_plan import AgentsError, make_agent

LIMIT_TICKS = 2400
ANSWER_S = 20.0
REACH_S = 5.0
WAY_M, PARKED_M, PARKED_ASIDE_M = 120.0, 40.0, 0.3
"""Length of the drive, and where the car is parked: ahead, and to the right of the lane's center (m).

BehaviorAgent does not detect a vehicle that is exactly straight ahead.
"""


def main(host: str = "127.0.0.1", port: int = 2000) -> bool:
    """Drive along a street in which a car is parked. Return True if the vehicle arrived."""
    try:
        # Without a server, the client library would wait for its whole timeout.
        socket.create_connection((host, port), timeout=REACH_S).close()
        client = carla.Client(host, port)
        client.set_timeout(ANSWER_S)
        world = client.get_world()
    except (OSError, RuntimeError):
        sys.exit(f"no CARLA server at {host}:{port}; start CARLA or carlette, or give HOST PORT")
    start = straight_start(world.get_map())
    world.apply_settings(carla.WorldSettings(synchronous_mode=True, fixed_delta_seconds=0.05))
    cars: list[carla.Vehicle] = []
    try:
        place_cars(world, start, cars)
        return drive(world, cars[0], start.next(WAY_M)[0].transform.location)
    except AgentsError as error:
        sys.exit(str(error))
    finally:
        for car in cars:
            car.destroy()
        world.apply_settings(carla.WorldSettings(synchronous_mode=False))


def drive(world: carla.World, vehicle: carla.Vehicle, goal: carla.Location) -> bool:
    """Drive a vehicle to a place with BehaviorAgent and StuckSolver. Return True if it arrived."""
    agent = make_agent(BehaviorAgent, vehicle, "normal", world.get_map())
    began_s = world.get_snapshot().timestamp.elapsed_seconds

    def tell(event: Event) -> None:
        print(f"{event.time_s - began_s:6.1f} s  {event.kind.value}: {event.text}", event.verdict or "")

    agent.set_destination(goal)
    helped = stucksolver_carla.attach(agent, ladder="evaluation", clock="lockstep", on_event=tell)
    try:
        for _ in range(LIMIT_TICKS):
            vehicle.apply_control(helped.run_step())
            world.tick()
            if helped.done():
                return True
        return False
    finally:
        helped.close()


def place_cars(world: carla.World, start: carla.Waypoint, cars: list[carla.Vehicle]) -> None:
    """Place the vehicle at the start and the parked car ahead of it, and append both to `cars`."""
    blueprint = world.get_blueprint_library().find("vehicle.lincoln.mkz_2020")
    ahead = start.next(PARKED_M)[0].transform
    ahead.location += PARKED_ASIDE_M * ahead.get_right_vector() + carla.Location(z=0.3)
    place = start.transform
    place.location.z += 0.3
    cars.extend(world.spawn_actor(blueprint, where) for where in (place, ahead))
    world.tick()


def straight_start(town: carla.Map) -> carla.Waypoint:
    """Return a waypoint from which a lane is straight for 130 m, without a junction."""
    for transform in town.get_spawn_points():
        start = town.get_waypoint(transform.location)
        way = [start, *(found[0] for found in (start.next(d) for d in (30.0, 60.0, 90.0, 130.0)) if found)]
        turns = [abs(w.transform.rotation.yaw - start.transform.rotation.yaw) % 360.0 for w in way]
        if len(way) == 5 and not any(w.is_junction for w in way) and max(turns) < 5.0:
            return start
    raise SystemExit("this town has no straight street of 130 m; choose another one, such as Town01")


if __name__ == "__main__":
    host, port = sys.argv[1:3] if len(sys.argv) > 2 else ("127.0.0.1", "2000")
    if not port.isdecimal():
        sys.exit(f"'{port}' is not a port; give HOST PORT, for example 127.0.0.1 2000")
    arrived = main(host, int(port))
    print("arrived" if arrived else "did not arrive")
    sys.exit(0 if arrived else 1)
