"""CARLA's BehaviorAgent with StuckSolver, on a street with a car parked in its lane.

Needs a running server (carlette or CARLA), and CARLA's `agents` package on the path:
python examples/behavior_agent.py [HOST PORT]
"""

from __future__ import annotations

import socket
import sys

try:
    import carla
except ModuleNotFoundError:
    sys.exit("the carla package is not installed: pip install 'stucksolver[sim]'")
try:
    from agents.navigation.behavior_agent import BehaviorAgent
except ModuleNotFoundError as error:
    sys.exit(f"no module {error.name!r}: it comes with CARLA; add its folder PythonAPI/carla to PYTHONPATH")

import stucksolver
from stucksolver.solver import Event

LIMIT_TICKS = 2400
ANSWER_S = 20.0
REACH_S = 5.0


def main(host: str = "127.0.0.1", port: int = 2000) -> bool:
    """Drives 120 m, past a car that stands 40 m ahead. True if it arrived."""
    try:
        # Without a server, the client library would wait for its whole timeout.
        socket.create_connection((host, port), timeout=REACH_S).close()
        client = carla.Client(host, port)
        client.set_timeout(ANSWER_S)
        world = client.get_world()
    except (OSError, RuntimeError):
        sys.exit(f"no CARLA server at {host}:{port}; start CARLA or carlette, or give HOST PORT")
    world.apply_settings(carla.WorldSettings(synchronous_mode=True, fixed_delta_seconds=0.05))
    blueprint = world.get_blueprint_library().find("vehicle.lincoln.mkz_2020")
    start = straight_start(world.get_map())
    ahead = start.next(40.0)[0].transform
    # Slightly off the centre: BehaviorAgent does not see a vehicle that is exactly straight ahead.
    ahead.location += 0.3 * ahead.get_right_vector() + carla.Location(z=0.3)
    place = start.transform
    place.location.z += 0.3
    cars = [world.spawn_actor(blueprint, place), world.spawn_actor(blueprint, ahead)]
    world.tick()
    agent = BehaviorAgent(cars[0], behavior="normal")
    agent.set_destination(start.next(120.0)[0].transform.location)

    def tell(event: Event) -> None:
        print(f"{event.time_s:6.1f} s  {event.kind.value}: {event.text}", event.verdict or "")

    helped = stucksolver.attach(agent, ladder="evaluation", clock="lockstep", on_event=tell)
    for _ in range(LIMIT_TICKS):
        cars[0].apply_control(helped.run_step())
        world.tick()
        if helped.done():
            break
    came = helped.done()
    helped.close()
    for car in cars:
        car.destroy()
    world.apply_settings(carla.WorldSettings(synchronous_mode=False))
    return came


def straight_start(town: carla.Map) -> carla.Waypoint:
    """A waypoint from which a lane is straight for 130 m, without a junction."""
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
    print("arrived" if main(host, int(port)) else "did not arrive")
