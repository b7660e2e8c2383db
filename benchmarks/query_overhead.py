"""Does the control loop notice that a model is being asked? The step's time while a query is open, and while none is.

A chat server on this machine is as slow as it is told; the real client waits for it in its own thread. Figures are
microseconds of the control thread's own processor time, medians and 99th percentiles, and their ratios; `ms_late_*` is
by how much a tick that should come every 5 ms came late by the wall clock, at the 99th percentile.
"""

from __future__ import annotations

import statistics
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from benchmarks.solver_overhead import parked_car
from stucksolver.decision.behaviors import REGISTRY, describe
from stucksolver.ladder import Ladder, parse_ladder, profile_text
from stucksolver.reason import Reasoner, RuleReasoner
from stucksolver.reason.llm import Budget, LanguageModelReasoner, ModelSettings, UsageLimits
from stucksolver.reason.llm.openai_api import OpenAiChat
from stucksolver.scene import Scene, Status, Surroundings
from stucksolver.scene.build import build_scene
from stucksolver.scene.view import FrenetScene
from stucksolver.solver import StuckSolver

TICK_S = 0.005
RUNG = """
[[rung]]
kind = "model"
deadline_s = 100.0
tries = 100
cooldown_s = 0.1
repair_rounds = 0
"""


def run(smoke: bool) -> dict[str, float]:
    """`us_*` for each step, `open` with a query under way, `free` while the vehicle drives."""
    seconds = 0.5 if smoke else 5.0
    free, free_late = _drive(RuleReasoner(), seconds, speed_mps=8.0)
    with _SlowServer(seconds * 4) as server:
        model = OpenAiChat("slow", server)
        asked = LanguageModelReasoner(model, settings=ModelSettings(deadline_s=90.0), purse=UsageLimits(None, Budget()))
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
    """Times of all steps after the question was put, in microseconds, and how late each tick was, in seconds."""
    surroundings = parked_car()
    costs: list[float] = []
    late: list[float] = []
    with StuckSolver(_scene, models={"model": reasoner}, ladder=_ladder(), clock="wall") as solver:
        begin = time.monotonic()
        for tick in range(int(seconds / TICK_S)):
            due = begin + tick * TICK_S
            time.sleep(max(due - time.monotonic(), 0.0))
            late.append(time.monotonic() - due)
            # Twelve seconds in one step of the clock: the detector sees a vehicle that has long stood.
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
    """Takes a request and answers it after so many seconds with an error."""

    def __init__(self, seconds: float) -> None:
        over = self._over = threading.Event()

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                self.rfile.read(int(self.headers["content-length"]))
                over.wait(seconds)
                self.close_connection = True

            def log_message(self, *_: object) -> None:
                """Quiet."""

        self._http = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._http.daemon_threads = True

    def __enter__(self) -> str:
        threading.Thread(target=self._http.serve_forever, daemon=True).start()
        return f"http://127.0.0.1:{self._http.server_port}/v1"

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._http.shutdown()
        self._http.server_close()
