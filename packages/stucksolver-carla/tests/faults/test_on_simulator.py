"""Faults with everything real: the simulator, the client, the driver, the stack."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TypeVar

import pytest

carla = pytest.importorskip("carla")

from ride import DT_S, Ride  # noqa: E402

from stucksolver.ladder import profile  # noqa: E402
from stucksolver.reasoners.faulty import make_faulty  # noqa: E402
from stucksolver.record import replay  # noqa: E402
from stucksolver.record.recorder import RUN_ENDED  # noqa: E402
from stucksolver.solver import EventKind  # noqa: E402
from stucksolver_carla.client_connection import SimulatorServer  # noqa: E402
from stucksolver_carla.observer import VehicleNotFoundError, VehicleObserver  # noqa: E402
from stucksolver_eval.simulator_server import carlette_server  # noqa: E402

pytestmark = pytest.mark.integration
T = TypeVar("T")


@pytest.fixture(scope="module")
def server() -> Iterator[SimulatorServer]:
    with carlette_server("demo_town") as found:
        yield found


@pytest.fixture(scope="module")
def client(server: SimulatorServer) -> Ride:
    """One for all tests: a second client that changes the settings of a world that stands waits a second for it."""
    return Ride(server.host, server.port)


@pytest.fixture
def ride(client: Ride) -> Iterator[Ride]:
    client.clear()
    yield client
    client.clear()


def collisions(ride: Ride) -> list[object]:
    """A sensor on the ego; what it hears is in the list."""
    hits: list[object] = []
    blueprint = ride.world.get_blueprint_library().find("sensor.other.collision")
    ride.sensor = ride.world.spawn_actor(blueprint, carla.Transform(), attach_to=ride.ego)
    ride.sensor.listen(hits.append)
    return hits


def test_recovery_with_frozen_or_jumping_frames_has_no_contact(ride: Ride) -> None:
    """Frames that freeze or jump on the way prevent no recovery and cause no contact."""
    ride.place()
    hits, seen, count = collisions(ride), [], [0]

    def spoiled(now):
        """A frozen second, one without frames, and a jump of 3 m, one after the other."""
        count[0] += 1
        seen.append(now)
        if 40 < count[0] <= 60:
            return seen[39]
        if 80 < count[0] <= 100:
            return None
        if 120 < count[0] <= 140:
            return now.model_copy(update={"ego": now.ego.model_copy(update={"y_m": now.ego.y_m + 3.0})})
        return now

    ride.drive(60.0, look=spoiled)
    ride.sensor.destroy()
    assert hits == []
    assert EventKind.RECOVERED in ride.kinds()
    assert {"the same frame for 0.5 s", "there are no surroundings", "the position jumped"} <= set(
        ride.texts(EventKind.FAULT)
    )


@pytest.mark.parametrize(
    "name",
    ["random", *(pytest.param(item, marks=pytest.mark.release) for item in ("always_left", "always_drive_over"))],
)
def test_a_hostile_reasoner_touches_nobody(ride: Ride, name: str) -> None:
    ride.place()
    hits = collisions(ride)
    ride.drive(25.0, reasoner=make_faulty(name, seed=2))
    ride.sensor.destroy()
    assert hits == []
    assert EventKind.DECIDED in ride.kinds()


@pytest.mark.slow
def test_solver_killed_in_plan_leaves_record_and_stack_drives(
    server: SimulatorServer, ride: Ride, tmp_path: Path
) -> None:
    """After a kill during a plan, the record is valid and the stack drives by itself."""
    program = Path(__file__).with_name("ride.py")
    command = [sys.executable, str(program), server.host, str(server.port), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == -signal.SIGKILL, done.stderr
    (file,) = tmp_path.glob("*.jsonl")
    report = replay(file)
    assert report.matches and report.ended is None
    assert report.ticks > 20
    # Nobody drives; the stack takes its seat again, without us, and nothing is left of the plan.
    ride.take()
    hits = collisions(ride)
    ride.alone(12.0)
    ride.sensor.destroy()
    assert hits == []


def while_ticking(ride: Ride, make: Callable[[], T]) -> T:
    """What `make` gives, while the world goes on."""
    with ThreadPoolExecutor(1) as pool:
        made = pool.submit(make)
        while not made.done():
            ride.world.tick()
            time.sleep(0.01)
    return made.result()


def test_a_watcher_changes_nothing_and_sees_it_all(server: SimulatorServer, ride: Ride, tmp_path: Path) -> None:
    ride.place()
    world = carla.Client(server.host, server.port).get_world()
    before = world.get_settings()
    watching = while_ticking(
        ride, lambda: VehicleObserver(world, "hero", profile("default"), tmp_path, lambda event: None)
    )
    errors: list[Exception] = []
    over = threading.Event()

    def look_on() -> None:
        try:
            while not over.is_set():
                watching.step()
        except RuntimeError as error:
            errors.append(error)

    looker = threading.Thread(target=look_on)
    looker.start()
    first = ride.world.get_snapshot().frame
    ticks = round(14.0 / DT_S)
    ride.alone(ticks * DT_S)
    assert ride.world.get_snapshot().frame == first + ticks
    over.set()
    ride.world.tick()
    looker.join(60.0)
    watching.close()
    assert errors == []
    after = world.get_settings()
    assert (after.synchronous_mode, after.fixed_delta_seconds) == (before.synchronous_mode, before.fixed_delta_seconds)
    assert watching.interventions == 1
    assert watching.state.startswith("stuck")
    assert all(replay(file).matches for file in watching.files) and len(watching.files) == 1


def test_watch_command_shows_state_and_ends_on_ctrl_c(server: SimulatorServer, ride: Ride) -> None:
    """The command shows the state and ends cleanly on Ctrl-C."""
    ride.place()
    code = "import sys; from stucksolver.commands import main; sys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-c", code, "watch", "--host", server.host, "--port", str(server.port)]
    watch = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert watch.stderr is not None
        first = while_ticking(ride, watch.stderr.readline)
        watch.send_signal(signal.SIGINT)
        out, err = while_ticking(ride, lambda: watch.communicate(timeout=120))
    finally:
        watch.kill()
    assert watch.returncode == 0, err
    assert "m/s" in first
    assert "interventions" in out
    assert "Traceback" not in err


@pytest.mark.slow
def test_watch_command_with_time_limit_writes_record_end(server: SimulatorServer, ride: Ride, tmp_path: Path) -> None:
    """A watch with a time limit writes the end of its record."""
    ride.place()
    code = "import sys; from stucksolver.commands import main; sys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-c", code, "watch", "--host", server.host, "--port", str(server.port)]
    command += ["--seconds", "12", "--out", str(tmp_path)]
    watch = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    out, err = while_ticking(ride, lambda: watch.communicate(timeout=200))
    assert watch.returncode == 0, err
    assert "1 interventions" in out
    (file,) = tmp_path.glob("*.jsonl")
    report = replay(file)
    assert report.matches and report.ended == RUN_ENDED


def test_observer_unknown_role_is_rejected_with_known_roles(server: SimulatorServer, ride: Ride) -> None:
    """A car that does not exist is reported with the existing ones."""
    ride.place()
    world = carla.Client(server.host, server.port).get_world()
    with pytest.raises(VehicleNotFoundError, match=r"no vehicle has the role 'villain'; roles: hero, scenario"):
        while_ticking(ride, lambda: VehicleObserver(world, "villain", profile("default"), None, lambda event: None))
