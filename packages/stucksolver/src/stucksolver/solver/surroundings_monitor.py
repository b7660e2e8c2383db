"""The surroundings as the guard sees them, with their faults made visible as age.

The guard refuses and aborts on surroundings that are too old. A frozen sensor, missing data and a jump of position are
therefore all reported as age. An object that vanishes for a moment is kept where it must be, and a light that vanishes
is one of unknown state until its line is behind.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from stucksolver.guard.policy import ControlPolicy
from stucksolver.scene import EgoState, Surroundings, TrackedObject, TrafficControl
from stucksolver.scene.objects import VULNERABLE
from stucksolver.scene.plausibility import implausibility
from stucksolver.scene.wording import in_one_line
from stucksolver.solver.control_memory import ControlMemory

HOLD_S = 1.0
"""An object that is no longer seen is kept for this long and extrapolated."""
SAME_S = 1e-6
"""Times this close are equal: ticks are sums of tenths of a second."""
JUMP_M = 1.5
"""The position may differ from the one that the speed leads to by at most this distance."""
NEAR_S = 0.5
"""Only looks at most this far apart can reveal a jump."""
DISTRUST_S = 0.5
"""The position is not believed for this long after a jump."""
DOUBTFUL_AGE_S = 60.0
"""The age given to surroundings that are not believed; no guard accepts it."""
FROZEN_TELL_S = 0.5
"""Surroundings that have been the same, or are older, for longer than this are reported. No guard's policy accepts much
older ones (`GuardPolicy.max_age_s`).
"""
FAULT_STAYS_S = 1.0
"""A fault is shown for this long after it was last found: one that comes and goes is one fault."""
MOVING_MPS = 0.5

Read = Callable[[], "Surroundings | None"]


@dataclass(frozen=True)
class _RawSample:
    now_s: float
    raw: Surroundings
    controls: tuple[TrafficControl, ...]


class SurroundingsMonitor:
    """Reads the stack's surroundings. Every call takes the solver's own time.

    Args:
        controls: The guard's numbers for lights and stop signs; the defaults if None.
    """

    def __init__(self, controls: ControlPolicy | None = None) -> None:
        self._controls = ControlMemory(controls)
        self._last: _RawSample | None = None
        self._fresh_s = -math.inf
        """The time at which the current frame was first shown."""
        self._jumped_s = -math.inf
        self._trusted: EgoState | None = None
        self._trusted_s = 0.0
        self._seen: dict[str, tuple[TrackedObject, float]] = {}
        self._fault_s = -math.inf
        self.fault: str | None = None
        """The current fault, in a few words."""

    def look(self, read: Read, now_s: float, clock_s: float | None = None) -> Surroundings | None:
        """Return the surroundings at this tick, or None if nothing was ever seen.

        Args:
            read: Returns the stack's surroundings.
            now_s: The solver's own time (s).
            clock_s: The stack's time (s), with which the time of the surroundings is compared; None: not compared.
        """
        raw, why = _read(read)
        if raw is None:
            return self._missing(now_s, why)
        age, fault = self._doubt(raw, now_s)
        behind_s = 0.0 if clock_s is None else min(now_s - raw.time_s, clock_s - raw.time_s, key=abs)
        if abs(behind_s) > max(raw.age_s, FROZEN_TELL_S):
            age = max(age, abs(behind_s))
        self._show(fault or "; ".join(raw.sensor_faults) or _late(raw.age_s, behind_s), now_s)
        ego = self._believed(raw.ego, now_s, jumped=age == DOUBTFUL_AGE_S)
        objects = self._kept(raw.objects, now_s)
        # Where the ego is not known, no line has a place.
        controls = raw.controls if age == DOUBTFUL_AGE_S else self._controls.controls(raw)
        self._last = _RawSample(now_s, raw, controls)
        if age == raw.age_s and objects is raw.objects and controls is raw.controls:
            return raw
        return raw.model_copy(update={"age_s": age, "objects": objects, "ego": ego, "controls": controls})

    def blind_s(self, now_s: float) -> float:
        """Seconds since anything new was seen."""
        return now_s - self._fresh_s

    def _show(self, fault: str | None, now_s: float) -> None:
        """Show a fault in the same words while it lasts, although its numbers may change on each tick."""
        if fault is not None and self.fault is not None and _kind(fault) == _kind(self.fault):
            self._fault_s = now_s
        elif self.fault is None or not 0.0 <= now_s - self._fault_s <= FAULT_STAYS_S:
            self.fault, self._fault_s = fault, now_s

    def _missing(self, now_s: float, why: str) -> Surroundings | None:
        self._show(why, now_s)
        if self._last is None:
            return None
        raw, controls = self._last.raw, self._last.controls
        return raw.model_copy(update={"age_s": raw.age_s + max(now_s - self._fresh_s, 0.0), "controls": controls})

    def _doubt(self, raw: Surroundings, now_s: float) -> tuple[float, str | None]:
        """Return the age to report, and the fault."""
        last = self._last
        if last is None or now_s <= last.now_s:
            if last is None or not _same(last.raw, raw):
                self._fresh_s = now_s
            return raw.age_s, None
        if _same(last.raw, raw):
            stood = now_s - self._fresh_s
            fault = _unchanged(last.raw, raw) if stood > FROZEN_TELL_S else None
            return raw.age_s + stood, fault
        self._fresh_s = now_s
        passed = now_s - last.now_s
        if passed <= NEAR_S and _off_course(last.raw.ego, raw.ego, passed) > JUMP_M:
            self._jumped_s = now_s
        if now_s - self._jumped_s < DISTRUST_S:
            return DOUBTFUL_AGE_S, "the position jumped"
        return raw.age_s, None

    def _believed(self, ego: EgoState, now_s: float, *, jumped: bool) -> EgoState:
        """Return the ego; right after a jump it is extrapolated from the last believed position.

        A position reached only by a jump must not prove that a plan has passed its commit point.
        """
        before, passed = self._trusted, now_s - self._trusted_s
        self._trusted_s = now_s
        if jumped and before is not None:
            way = ego.speed_mps * max(passed, 0.0)
            x, y = before.x_m + way * math.cos(before.yaw_rad), before.y_m + way * math.sin(before.yaw_rad)
            ego = before.model_copy(update={"x_m": x, "y_m": y, "speed_mps": ego.speed_mps})
        self._trusted = ego
        return ego

    def _kept(self, objects: tuple[TrackedObject, ...], now_s: float) -> tuple[TrackedObject, ...]:
        """Return the objects seen now and those seen a moment ago.

        A tracker that states how well it knows places has its own memory: it keeps what is hidden, and ends a track
        when it has looked there often enough. Only vulnerable road users are kept longer than it says.
        """
        seen = self._seen
        for o in objects:
            seen[o.id] = (o, now_s)
        if len(seen) == len(objects):
            return objects
        held: list[TrackedObject] = []
        for name, (o, when) in list(seen.items()):
            if when == now_s:
                continue
            remembers = o.position_sd_m is not None and o.kind not in VULNERABLE
            if 0.0 <= now_s - when <= HOLD_S + SAME_S and not remembers:
                held.append(_gone_on(o, now_s - when))
            else:
                del seen[name]
        return (*objects, *held) if held else objects


def _read(read: Read) -> tuple[Surroundings | None, str]:
    """Read the stack's surroundings: None with the reason if they cannot be used. Catches whatever the stack raises."""
    try:
        raw: Any = read()
    except Exception as error:  # noqa: BLE001 - a stack's own fault, of whatever type, must not end the control loop
        return None, f"the stack's surroundings raised {in_one_line(error)}"
    if raw is None:
        return None, "there are no surroundings"
    if not issubclass(type(raw), Surroundings):
        return None, f"the stack returned a {type(raw).__name__} as surroundings"
    wrong = implausibility(raw)
    return (raw, "") if wrong is None else (None, f"the surroundings are inconsistent: {wrong}")


def _kind(fault: str) -> str:
    """Return what stays the same in the words of a fault."""
    return re.sub(r"[-+.\d]+", "", fault.split(" is ")[0])


def _late(age_s: float, behind_s: float) -> str | None:
    """Return what is wrong with the age of surroundings, and what to do; None if they are new enough."""
    if age_s > FROZEN_TELL_S:
        oldest = f"no plan begins on data older than {FROZEN_TELL_S:g} s"
        return f"surroundings.age_s is {age_s:.1f} s: {oldest}; give newer data"
    if abs(behind_s) > FROZEN_TELL_S:
        where = "behind" if behind_s > 0.0 else "ahead of"
        remedy = "stamp both from one clock, or give the age of the data in age_s"
        return f"surroundings.time_s is {abs(behind_s):.1f} s {where} status.time_s; {remedy}"
    return None


def _unchanged(last: Surroundings, raw: Surroundings) -> str:
    """Return the fault of surroundings that have been the same for too long."""
    if last.frame == raw.frame and last.time_s != raw.time_s:
        return f"surroundings.frame is {raw.frame} for {FROZEN_TELL_S:g} s; give new data another number"
    return f"the same frame for {FROZEN_TELL_S:g} s"


def _same(first: Surroundings, second: Surroundings) -> bool:
    """True if this is the same frame: the same number, or a moving ego or moving objects that have not moved."""
    if first is second or first.frame == second.frame:
        return True
    a, b = first.ego, second.ego
    if _frozen(first, second):
        return True
    return abs(b.speed_mps) > MOVING_MPS and (a.x_m, a.y_m, a.yaw_rad) == (b.x_m, b.y_m, b.yaw_rad)


def _frozen(first: Surroundings, second: Surroundings) -> bool:
    """True if no moving object has moved although the frame number changed: the list is frozen."""
    if len(first.objects) != len(second.objects):
        return False
    pairs = list(zip(first.objects, second.objects, strict=True))
    moving = [(a, b) for a, b in pairs if math.hypot(b.vx_mps, b.vy_mps) > MOVING_MPS]
    return bool(moving) and all(a.id == b.id and (a.x_m, a.y_m) == (b.x_m, b.y_m) for a, b in moving)


def _off_course(before: EgoState, after: EgoState, dt_s: float) -> float:
    """Distance of the position from any that the speed could have led to (m)."""
    moved = math.hypot(after.x_m - before.x_m, after.y_m - before.y_m)
    return moved - max(abs(before.speed_mps), abs(after.speed_mps)) * dt_s


def _gone_on(o: TrackedObject, dt_s: float) -> TrackedObject:
    return o.model_copy(update={"x_m": o.x_m + o.vx_mps * dt_s, "y_m": o.y_m + o.vy_mps * dt_s})
