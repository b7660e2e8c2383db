"""StuckSolver with your own stack: a point drives along a straight street, and a car is parked in its lane.

Run it with python examples/own_stack.py. It needs no simulator.
"""

from __future__ import annotations

import math

import numpy as np

from stucksolver import Directive, Execute, Scene, Status, StuckSolver, Surroundings
from stucksolver.plan.behaviors import describe
from stucksolver.scene import (
    EgoState,
    LaneDirection,
    LaneKind,
    LaneSight,
    LaneStrip,
    LineKind,
    ObjectKind,
    RoadGeometry,
    TrackedObject,
)
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.scene_builder import build_scene

DT_S = 0.05
STATIONS = 301
OFFERS = ("wait", "keep_lane", "change_lane", "borrow_oncoming_lane")
"""The behaviors that this stack can perform; it cannot reverse."""


def lane(name: str, offset_m: float, direction: LaneDirection, line: LineKind) -> LaneStrip:
    """A lane along the route, sampled every meter. `line` is the marking that must be crossed to enter it."""
    return LaneStrip(
        id=name,
        kind=LaneKind.DRIVING,
        direction=direction,
        start=0,
        offset_m=(offset_m,) * STATIONS,
        width_m=(3.5,) * STATIONS,
        line=(line,) * STATIONS,
        speed_limit_mps=13.4,
    )


ROAD = RoadGeometry(
    key="street",
    spacing_m=1.0,
    reference=tuple((float(x), 0.0) for x in range(STATIONS)),
    lanes=(
        lane("own", 0.0, LaneDirection.SAME, LineKind.NONE),
        lane("oncoming", 3.5, LaneDirection.OPPOSITE, LineKind.BROKEN),
    ),
)


class PointStack:
    """A point that drives straight, stops 5 m behind the parked car, and follows paths exactly."""

    def __init__(self) -> None:
        self.time_s, self.x, self.y, self.yaw, self.speed = 0.0, 0.0, 0.0, 0.0, 0.0
        self.parked_x = 60.0

    def status(self) -> Status:
        return Status(time_s=self.time_s, speed_mps=self.speed, progress_m=self.x, at_destination=self.x > 120.0)

    def surroundings(self) -> Surroundings:
        ego = EgoState(x_m=self.x, y_m=self.y, yaw_rad=self.yaw, speed_mps=self.speed, length_m=4.9, width_m=1.85)
        parked = TrackedObject(
            id="parked",
            kind=ObjectKind.CAR,
            x_m=self.parked_x,
            y_m=0.0,
            yaw_rad=0.0,
            vx_mps=0.0,
            vy_mps=0.0,
            length_m=4.7,
            width_m=1.9,
            height_m=1.5,
            stationary_s=self.time_s,
        )
        sight = tuple(LaneSight(lane_id=strip.id, ahead_m=250.0, behind_m=60.0) for strip in ROAD.lanes)
        frame = round(self.time_s / DT_S)
        return Surroundings(frame=frame, time_s=self.time_s, ego=ego, objects=(parked,), sight=sight, road=ROAD)

    def scene(self, seen: Surroundings | None = None) -> Scene:
        """The scene of what the solver has seen. A bridge passes nothing; then the current surroundings are used."""
        return build_scene(FrenetScene(seen or self.surroundings()), self.status(), describe(OFFERS))

    def perform(self, directive: Directive) -> None:
        if isinstance(directive, Execute):
            xs = [p.x_m for p in directive.path] or [self.x]
            ys = [p.y_m for p in directive.path] or [self.y]
            bounds = [p.speed_mps for p in directive.path] or [0.0]
            self.y = float(np.interp(self.x, xs, ys))
            # The guard checks the path from the vehicle's real heading, so a stack must report it.
            self.yaw = math.atan2(float(np.interp(self.x + 0.5, xs, ys)) - self.y, 0.5)
            wanted = float(np.interp(self.x, xs, bounds))
        else:
            self.yaw = 0.0
            room = self.parked_x - 9.8 - self.x if self.x < self.parked_x else 1e3
            wanted = min(8.0, (4.0 * max(room, 0.0)) ** 0.5)
        self.speed += float(np.clip(wanted - self.speed, -6.0 * DT_S, 1.5 * DT_S))
        self.x += self.speed * DT_S
        self.time_s += DT_S


def main() -> None:
    stack = PointStack()
    with StuckSolver(
        stack.scene, clock="lockstep", on_event=lambda e: print(f"{e.time_s:5.1f} s  {e.kind.value}: {e.text}")
    ) as solver:
        while not stack.status().at_destination and stack.time_s < 60.0:
            directive = solver.step(stack.status(), stack.surroundings)
            stack.perform(directive)
    print(f"{stack.time_s:5.1f} s  at {stack.x:.0f} m")


if __name__ == "__main__":
    main()
