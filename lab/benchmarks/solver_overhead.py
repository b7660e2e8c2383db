"""Time that the solver adds to a stack: per tick of free driving, and per call of the guard, the duties and the view.

The metrics are medians of many batches, in microseconds of the thread's CPU time, which other work affects less.
Metrics per tick are also given as a ratio to an empty loop that calls a trivial method, measured in the same run, so
that machines can be compared.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable
from typing import NoReturn

from stucksolver.guard import Guard
from stucksolver.immobilization import Detector
from stucksolver.plan import WaitLimits
from stucksolver.plan.behaviors import REGISTRY, BackUp, BorrowOncomingLane, describe
from stucksolver.reasoners.duties import decide_wait
from stucksolver.scene import (
    EgoState,
    LaneDirection,
    LaneKind,
    LaneSight,
    LaneStrip,
    LineKind,
    ObjectKind,
    RoadGeometry,
    Status,
    Surroundings,
    TrackedObject,
)
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.scene_builder import build_scene
from stucksolver.solver import StuckSolver

ACTORS = 30
"""Number of road users."""
STATIONS = 401
"""Number of points of the road."""
LANE_M = 3.5
"""Width of a lane (m)."""


def run(smoke: bool) -> dict[str, float]:
    """Return `us_*`, microseconds per call, and `ratio_*`, the ratio of each tick metric to `us_empty_loop`."""
    batches = 5 if smoke else 60
    figures = _ticks(batches, 200 if smoke else 2000) | _looks(batches, 2 if smoke else 10)
    for name in ("detector", "step"):
        figures[f"ratio_{name}"] = figures[f"us_{name}"] / figures["us_empty_loop"]
    return figures


def _ticks(batches: int, calls: int) -> dict[str, float]:
    """Return the times of the detector alone and of the whole step in free driving (us)."""
    statuses = [Status(time_s=0.05 * k, speed_mps=8.0, progress_m=0.4 * k) for k in range(batches * calls)]
    nothing, detector = _Nothing(), Detector()
    figures = {
        "us_empty_loop": _each(statuses, batches, nothing.update),
        "us_detector": _each(statuses, batches, detector.update),
    }
    with StuckSolver(_never, clock="lockstep") as solver:
        figures["us_step"] = _each(statuses, batches, lambda status: solver.step(status, _never))
    return figures


def _looks(batches: int, calls: int) -> dict[str, float]:
    """Return the times of calls that happen only while a plan is pending or running, with 30 actors around (us)."""
    surroundings, guard, limits = parked_car(), Guard(), WaitLimits()
    view = FrenetScene(surroundings)
    scene = build_scene(view, Status(time_s=0.0, speed_mps=0.0, progress_m=0.0), describe(tuple(REGISTRY)))
    plan = [BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)]
    verdict, proven = guard.accept(plan, view, guided=False)
    if proven is None:
        raise RuntimeError(f"the guard rejected the benchmark's own plan: {verdict}")
    again, crowd = proven, _crowd(surroundings)
    back = guard.accept([BackUp(distance_m=5.0)], view, guided=False)[1]
    if back is None:
        raise RuntimeError("the guard rejected the benchmark's plan to back up")
    return {
        "us_view": median_us(batches, calls, lambda: FrenetScene(surroundings)),
        "us_accept": median_us(batches, calls, lambda: guard.accept(plan, FrenetScene(surroundings), guided=False)),
        "us_accept_crowd": median_us(batches, calls, lambda: guard.accept(plan, FrenetScene(crowd), guided=False)),
        "us_recheck": median_us(batches, calls, lambda: guard.recheck(again, FrenetScene(surroundings))),
        "us_recheck_backwards": median_us(batches, calls, lambda: guard.recheck(back, FrenetScene(surroundings))),
        "us_recheck_crowd": median_us(batches, calls, lambda: guard.recheck(again, FrenetScene(crowd))),
        "us_duties": median_us(batches, calls, lambda: decide_wait(scene, limits)),
    }


class _Nothing:
    def update(self, status: Status) -> None:
        return None


def _never(surroundings: object = None) -> NoReturn:
    raise RuntimeError("free driving requested the surroundings")


def _each(statuses: list[Status], batches: int, call: Callable[[Status], object]) -> float:
    """Return the median time of a call over batches of statuses (us)."""
    size = len(statuses) // batches
    times = []
    for k in range(batches):
        batch = statuses[k * size : (k + 1) * size]
        start = time.thread_time()
        for status in batch:
            call(status)
        times.append((time.thread_time() - start) / size * 1e6)
    return statistics.median(times)


def median_us(batches: int, calls: int, call: Callable[[], object]) -> float:
    """Return the median time of a call over batches of calls (us of the thread's CPU time)."""
    times = []
    for _ in range(batches):
        start = time.thread_time()
        for _ in range(calls):
            call()
        times.append((time.thread_time() - start) / calls * 1e6)
    return statistics.median(times)


def parked_car() -> Surroundings:
    """Return surroundings behind a parked car on a two-way road.

    They contain other parked cars, pedestrians, and traffic that has passed.
    """
    objects = [_object("lead", 75.0, 0.0, ObjectKind.CAR)]
    for k in range(ACTORS - 1):
        x = 40.0 + 9.0 * k
        if k % 3 == 0:
            objects.append(_object(f"parked {k}", x, -3.2, ObjectKind.CAR))
        elif k % 3 == 1:
            objects.append(_object(f"walker {k}", x, 9.0, ObjectKind.PEDESTRIAN, 1.3))
        else:
            objects.append(_object(f"passed {k}", -30.0 - 12.0 * k, LANE_M, ObjectKind.CAR, -8.0))
    road = _road()
    return Surroundings(
        frame=1,
        time_s=0.0,
        ego=EgoState(x_m=60.0, y_m=0.0, yaw_rad=0.0, speed_mps=0.0, length_m=4.9, width_m=1.85),
        objects=tuple(objects),
        sight=tuple(LaneSight(lane_id=lane.id, ahead_m=300.0, behind_m=80.0) for lane in road.lanes),
        road=road,
    )


def _crowd(surroundings: Surroundings) -> Surroundings:
    """Return the worst case: all pedestrians walk toward the path, so that the guard can filter out none of them."""
    walkers = [
        _object(f"walker {k}", 62.0 + 2.0 * k, 6.0 + k % 10, ObjectKind.PEDESTRIAN).model_copy(update={"vy_mps": -1.2})
        for k in range(ACTORS - 1)
    ]
    return surroundings.model_copy(update={"objects": (surroundings.objects[0], *walkers)})


def _object(name: str, x: float, y: float, kind: ObjectKind, speed: float = 0.0) -> TrackedObject:
    small = kind is ObjectKind.PEDESTRIAN
    return TrackedObject(
        id=name,
        kind=kind,
        x_m=x,
        y_m=y,
        yaw_rad=math.pi if speed < 0 else 0.0,
        vx_mps=speed,
        vy_mps=0.0,
        length_m=0.5 if small else 4.6,
        width_m=0.5 if small else 1.9,
        height_m=1.7,
        stationary_s=0.0 if speed else 60.0,
        hazard_lights=False,
    )


def _road() -> RoadGeometry:
    def lane(name: str, offset: float, direction: LaneDirection, line: LineKind) -> LaneStrip:
        return LaneStrip(
            id=name,
            kind=LaneKind.DRIVING,
            direction=direction,
            start=0,
            offset_m=(offset,) * STATIONS,
            width_m=(LANE_M,) * STATIONS,
            line=(line,) * STATIONS,
            speed_limit_mps=13.4,
        )

    return RoadGeometry(
        key="benchmark",
        spacing_m=1.0,
        reference=tuple((float(x), 0.0) for x in range(STATIONS)),
        lanes=(
            lane("own", 0.0, LaneDirection.SAME, LineKind.NONE),
            lane("oncoming", LANE_M, LaneDirection.OPPOSITE, LineKind.BROKEN),
        ),
    )
