"""Checks whether binding lines are crossed, and whether the ego stops on rails."""

from __future__ import annotations

from lab.benchmarks.guard_oracle.scene import Control
from lab.benchmarks.guard_oracle.world import World
from stucksolver.scene import ControlKind, LightState, ZoneKind

STOPPED_MPS, AT_THE_LINE_M = 0.3, 6.0
"""Speed of a stop (m/s) and the distance before a line within which it counts as a stop at the line (m). Ours."""
MISSED_M = 0.3
"""Distance beyond which a line counts as crossed (m). Ours."""


class Watch:
    """Detects crossed lines and stops on rails."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.missed: list[str] = []
        self._could_stop: dict[int, bool] = {}
        self._was = world.ego_span()[1]
        self._began_on = {kind for kind, start, end in world.road.zones if self._on(start - 1.0, end)}
        self._stopped_at: set[int] = set()

    def _on(self, start: float, end: float) -> bool:
        rear, front, _, _ = self.world.ego_span()
        return rear < end and front - MISSED_M > start

    def update(self) -> None:
        world, front = self.world, self.world.ego_span()[1]
        for k, control in enumerate(world.setting.controls):
            room = control.line - front
            if abs(world.ego.speed) < STOPPED_MPS and -0.5 < room < AT_THE_LINE_M:
                self._stopped_at.add(k)
            binds = self._binds(control, k in self._stopped_at)
            if binds and k not in self._could_stop:
                stop = world.ego.speed**2 / (2 * 3.0) + 0.5 * world.ego.speed
                self._could_stop[k] = room > stop
            if self._was < control.line - 1e-9 <= front - MISSED_M and binds and self._could_stop.get(k, False):
                self._say(f"{control.kind.value} passed")
            if front - MISSED_M >= control.line:
                self._could_stop[k] = False
        self._was = min(front - MISSED_M, max(self._was, front - MISSED_M))
        for kind, start, end in world.road.zones:
            if kind is ZoneKind.LEVEL_CROSSING and self._on(start, end) and kind not in self._began_on:
                self._say("rails entered")

    def _say(self, what: str) -> None:
        if what not in self.missed:
            self.missed.append(what)

    def _binds(self, control: Control, stopped: bool) -> bool:
        """True if passing is forbidden.

        A stop sign and a dark light bind only until the vehicle has stopped at them.
        """
        front = self.world.ego_span()[1]
        if not control.line - front < control.seen_from:
            return False
        if control.kind is ControlKind.STOP_SIGN:
            return not stopped
        state = control.state(self.world.t)
        return state in (LightState.RED, LightState.UNKNOWN) or (state is LightState.OFF and not stopped)
