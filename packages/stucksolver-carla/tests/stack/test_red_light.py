"""A red light with everything real: the simulator, the client, the driver, the solver with its search and its guard."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

carla = pytest.importorskip("carla")

from stucksolver.plan import Directive, Execute  # noqa: E402
from stucksolver.solver import Event, EventKind, StuckSolver  # noqa: E402
from stucksolver_carla.client_connection import SimulatorServer  # noqa: E402
from stucksolver_carla.drivers.behavior import BehaviorDriver  # noqa: E402
from stucksolver_carla.stack import CarlaStack  # noqa: E402
from stucksolver_eval.scenarios.families.street import into_gear  # noqa: E402
from stucksolver_eval.simulator_server import carlette_server  # noqa: E402

pytestmark = pytest.mark.integration
DT_S = 0.05


@pytest.fixture(scope="module")
def server() -> Iterator[SimulatorServer]:
    with carlette_server("demo_town") as found:
        yield found


class Crossing:
    """The ego on its way through a junction whose light stays as it is set."""

    def __init__(self, server: SimulatorServer) -> None:
        client = carla.Client(server.host, server.port)
        client.set_timeout(60.0)
        self.world = client.load_world("demo_town")
        settings = self.world.get_settings()
        settings.synchronous_mode, settings.fixed_delta_seconds = True, DT_S
        self.world.apply_settings(settings)
        town = self.world.get_map()
        lights = self.world.get_actors().filter("*traffic_light*")
        self.light = next(light for light in lights if any(w.road_id == 11 for w in light.get_stop_waypoints()))
        (self.line,) = self.light.get_stop_waypoints()
        start = town.get_waypoint_xodr(11, 1, 60.0).transform
        start.location.z += 0.2
        self.ego = self.world.spawn_actor(self.world.get_blueprint_library().find("vehicle.tesla.model3"), start)
        into_gear(self.ego)
        for _ in range(10):
            self.world.tick()
        driver = BehaviorDriver(self.ego, carla_map=town)
        driver.set_destination(town.get_waypoint_xodr(21, -1, 30.0).transform.location)
        self.stack = CarlaStack(self.ego, driver, town)
        self.events: list[Event] = []
        self.solver = StuckSolver(
            self.stack.scene,
            ladder="evaluation",
            clock="lockstep",
            on_event=self.events.append,
        )

    def show(self, state: object) -> None:
        self.light.set_state(state)
        self.light.freeze(True)

    def drive(self, seconds: float) -> list[Directive]:
        found = []
        for _ in range(round(seconds / DT_S)):
            status = self.stack.status()
            found.append(self.solver.step(status, self.stack.surroundings))
            self.ego.apply_control(self.stack.perform(found[-1]))
            self.world.tick()
        return found

    def decisions(self) -> list[Event]:
        return [e for e in self.events if e.kind is EventKind.DECIDED]

    def before_the_line_m(self) -> float:
        """From the front bumper to the stop line; the ego drives towards lower x here."""
        return float(self.ego.get_location().x - self.ego.bounding_box.extent.x - self.line.transform.location.x)


@pytest.mark.slow
def test_red_light_waits_despite_guidance_and_goes_at_green(server: SimulatorServer) -> None:
    """Before a red light the ego waits, whatever a passenger says, and it goes at green."""
    crossing = Crossing(server)
    with crossing.solver:
        crossing.show(carla.TrafficLightState.Red)
        directives = crossing.drive(25.0)
        assert crossing.stack.status().speed_mps < 0.1
        assert 0.0 < crossing.before_the_line_m() < 6.0
        assert not any(isinstance(d, Execute) for d in directives)
        decided = crossing.decisions()
        assert decided and all(e.decision.plan is None for e in decided)
        assert {e.decision.analysis.wait.value for e in decided} == {"light"}
        crossing.solver.guide("just go")
        directives = crossing.drive(8.0)
        assert all(e.decision.plan is None for e in crossing.decisions())
        assert not any(isinstance(d, Execute) for d in directives)
        assert 0.0 < crossing.before_the_line_m() < 6.0
        crossing.show(carla.TrafficLightState.Green)
        crossing.drive(14.0)
        assert crossing.stack.status().at_destination
        assert all(e.decision.plan is None for e in crossing.decisions())
