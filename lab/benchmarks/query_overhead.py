"""Effect of a pending model query on the control loop: times a step with and without one.

The query goes to a deliberately slow chat server on this machine; the real client waits for it in its own thread.
`us_*` are microseconds of the control thread's CPU time, as medians or 99th percentiles. `ms_late_*` is the 99th
percentile of the delay of a tick that is due every 5 ms, in wall time.
"""

from __future__ import annotations

import statistics
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from lab.benchmarks.solver_overhead import parked_car
from stucksolver.ladder import Ladder, parse_ladder, profile_text
from stucksolver.plan.behaviors import REGISTRY, describe
from stucksolver.query_budget import QueryBudget
from stucksolver.reasoners import Reasoner, SearchReasoner
from stucksolver.scene import Scene, Status, Surroundings
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.scene_builder import build_scene
from stucksolver.solver import StuckSolver
from stucksolver_language.llm import LanguageModelReasoner, ModelSettings, UsageLimits
from stucksolver_language.llm.openai_api import OpenAiChat

TICK_S = 0.005
"""Period of the loop (s)."""
RUNG = """
[[rung]]
kind = "model"
deadline_s = 100.0
tries = 100
cooldown_s = 0.1
repair_rounds = 0
"""


def run(smoke: bool) -> dict[str, float]:
    """Return `us_*` per step and `ms_late_*`: `open` with a pending query, `free` in free driving."""
    seconds = 0.5 if smoke else 5.0
    free, free_late = _drive(SearchReasoner(), seconds, speed_mps=8.0)
    with _SlowServer(seconds * 4) as server:
        model = OpenAiChat("slow", server)
        asked = LanguageModelReasoner(
            model, settings=ModelSettings(deadline_s=90.0), usage_limits=UsageLimits(None, QueryBudget())
        )
        open_, open_late = _drive(asked, seconds, speed_mps=0.0)
        model.cancel()
    figures = {
        "us_free_median": statistics.median(free),
        "us_open_median": statistics.median(open_),
        "us_open_p99": _p99(open_),
        "ms_late_free": _p99(free_late) * 1e3,
        "ms_late_open": _p99(open_late) * 1e3,
    }
    return figures | {"ratio_open_to_tick_of_50_ms": figures["us_open_p99"] / 50_000.0}


def _drive(reasoner: Reasoner, seconds: float, speed_mps: float) -> tuple[list[float], list[float]]:
    """Return CPU time (us) and delay (s) of each step, without the first tenth, in which the query is sent."""
    surroundings = parked_car()
    costs: list[float] = []
    late: list[float] = []
    with StuckSolver(_scene, models={"model": reasoner}, ladder=_ladder(), clock="wall") as solver:
        begin = time.monotonic()
        for tick in range(int(seconds / TICK_S)):
            due = begin + tick * TICK_S
            time.sleep(max(due - time.monotonic(), 0.0))
            late.append(time.monotonic() - due)
            # The clock jumps by twelve seconds, so that the detector gets a vehicle that has long been stopped.
            now = tick * TICK_S + (12.0 if tick > 2 else 0.0)
            status = Status(time_s=now, speed_mps=speed_mps, progress_m=speed_mps * now)
            start = time.thread_time()
            solver.step(status, lambda: surroundings)
            costs.append((time.thread_time() - start) * 1e6)
    after_the_question = len(costs) // 10
    return costs[after_the_question:], late[after_the_question:]


def _scene(surroundings: Surroundings) -> Scene:
    return build_scene(
        FrenetScene(surroundings), Status(time_s=0.0, speed_mps=0.0, progress_m=0.0), describe(tuple(REGISTRY))
    )


def _ladder() -> Ladder:
    return parse_ladder(profile_text("evaluation").split("[[rung]]")[0] + RUNG, "benchmark")


def _p99(values: list[float]) -> float:
    return statistics.quantiles(values, n=100)[98]


class _SlowServer:
    """Accepts a request and closes the connection without an answer after the given time (s)."""

    def __init__(self, seconds: float) -> None:
        over = self._over = threading.Event()

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                self.rfile.read(int(self.headers["content-length"]))
                over.wait(seconds)
                self.close_connection = True

            def log_message(self, *_: object) -> None:
                """Write no log."""

        self._http = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._http.daemon_threads = True

    def __enter__(self) -> str:
        threading.Thread(target=self._http.serve_forever, daemon=True).start()
        return f"http://127.0.0.1:{self._http.server_port}/v1"

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._http.shutdown()
        self._http.server_close()
