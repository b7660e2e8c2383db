"""The body of a route's process: its own server, the run, and its files."""

from __future__ import annotations

import signal
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

from stucksolver.atomic_files import OutputError
from stucksolver.record import RecordError
from stucksolver_carla.client_connection import ServerError
from stucksolver_eval.results.outcome import RouteOutcome, State
from stucksolver_eval.results.store import ResultStore
from stucksolver_eval.runner.isolated_process import RunCancelledError, RunError, attempt, watched
from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.simulator_server import open_server

TRIES = 2
"""Number of attempts.

A process that was killed by a signal is started again, because the client library can crash. Ours.
"""
REASON_CHARACTERS = 2000
"""Longest reason in an outcome (characters). Ours."""


@dataclass(frozen=True)
class RouteTask:
    """A job and the folder for its files."""

    job: RouteJob
    folder: Path


def run_task(
    task: RouteTask, progress: Callable[[float], None] = lambda _: None, wanted: Callable[[], bool] = lambda: True
) -> RouteOutcome:
    """Drive a route in a separate process. It returns an outcome for any end of that process, and writes it to disk.

    Raises `OutputError` if the outcome cannot be written, and `RunCancelledError`.
    """
    store, job = ResultStore(task.folder), task.job
    reason = ""
    for _ in range(TRIES):
        try:
            code = attempt(_work, task, progress, wanted)
        except RunError as error:
            # The outcome contains the reason, and the other routes continue.
            reason = str(error)
            break
        found = store.outcome(job.route, job.seed)
        if code == 0 and found is not None:
            return found
        if code >= 0:
            reason = f"its process ended with exit code {code}; see its output above"
            break
        reason = f"its process was killed by {signal.Signals(-code).name}, {TRIES} times in a row"
    if not wanted():
        raise RunCancelledError
    outcome = _not_driven(job, "crashed", reason)
    store.write_outcome(job.route, outcome)
    return outcome


def drive_task(task: RouteTask, progress: Callable[[float], None] = lambda _: None) -> RouteOutcome:
    """Drive a route like `run_task`, but raise `RunError` with the reason if it could not be driven."""
    outcome = run_task(task, progress)
    if outcome.state != "driven":
        raise RunError(outcome.reason.strip().splitlines()[-1])
    return outcome


def _not_driven(job: RouteJob, state: State, reason: str) -> RouteOutcome:
    return RouteOutcome(
        route_id=job.route.id,
        scenario=job.scenario,
        town=job.route.town,
        seed=job.seed,
        arm=job.arm.name,
        state=state,
        reason=reason[-REASON_CHARACTERS:],
    )


def _work(task: RouteTask, theirs: Connection) -> None:
    # The parent handles Ctrl-C and ends this process. The end of the parent closes the pipe.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _leave)
    store, job = ResultStore(task.folder), task.job
    try:
        outcome = _driven(store, job, theirs)
    except BrokenPipeError:
        raise SystemExit(1) from None
    except OutputError as error:
        # The parent gets the error and ends the evaluation.
        theirs.send(str(error))
        return
    if outcome is not None:
        store.write_outcome(job.route, outcome)


def _driven(store: ResultStore, job: RouteJob, theirs: Connection) -> RouteOutcome | None:
    """Drive a route and write its files. Returns an outcome only if it could not be driven."""
    from stucksolver_carla.drivers.behavior import RouteError
    from stucksolver_carla.perception_interface import SensorError
    from stucksolver_eval.drivers import AgentError, carries_sensors
    from stucksolver_eval.runner.drive import DriveError, drive_route
    from stucksolver_eval.scenarios.scenario import ScenarioError, UnsupportedScenarioError
    from stucksolver_eval.systems import carries_camera
    from stucksolver_eval.systems.spec import SENSORS

    try:
        place = (job.route.town, job.maps, job.seed, job.host, job.port)
        sensing = carries_camera(job.arm) or carries_sensors(job.arm.driver) or job.recording is not None
        sensing = sensing or job.arm.perception == SENSORS or job.passenger is not None
        with open_server(*place, scenery=sensing, stands=True) as server, watched(server, theirs):
            store.write_driven(job.route, job.seed, drive_route(job, server, theirs.send))
            return None
    except UnsupportedScenarioError as error:
        # The outcome contains the reason.
        return _not_driven(job, "unsupported", str(error))
    except (ScenarioError, DriveError, RouteError) as error:
        # The outcome contains the reason.
        return _not_driven(job, "invalid", str(error))
    except (ServerError, RecordError, AgentError, SensorError) as error:
        # The outcome contains the reason.
        return _not_driven(job, "crashed", str(error))
    except (BrokenPipeError, OutputError):
        raise
    except Exception:  # noqa: BLE001 - a defect on one route must not stop the others; the traceback is stored
        return _not_driven(job, "crashed", traceback.format_exc())


def _leave(number: int, frame: object) -> None:
    """Exit on SIGTERM by unwinding, so that the server ends too."""
    raise SystemExit(1)
