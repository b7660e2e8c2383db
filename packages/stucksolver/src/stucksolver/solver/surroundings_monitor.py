"""Reads the surroundings for the guard, and reports their faults as age.

The guard rejects and aborts on surroundings that are too old. A frozen sensor, missing data and a jump of the position
are therefore all reported as age. An object that vanishes for a short time is kept at its extrapolated position. A
light that vanishes becomes one of unknown state until its line is behind the ego.
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
"""Time for which a vanished object is kept and extrapolated (s). Ours."""
SAME_S = 1e-6
"""Difference below which times are equal (s): ticks are sums of tenths of a second."""
JUMP_M = 1.5
"""Greatest difference between the position and the one that follows from the speed (m). Ours."""
NEAR_S = 0.5
"""Longest time between two readings that can reveal a jump (s). Ours."""
DISTRUST_S = 0.5
"""Time after a jump during which the position is not used (s). Ours."""
DOUBTFUL_AGE_S = 60.0
"""Age that is reported for surroundings with an unreliable position (s); no guard accepts it."""
FROZEN_TELL_S = 0.5
"""Age, or time without a change, above which surroundings are reported (s): about `GuardPolicy.max_age_s`."""
FAULT_STAYS_S = 1.0
"""Time for which a fault is shown after it was last found (s): an intermittent fault is one fault. Ours."""
MOVING_MPS = 0.5
"""Speed above which an unchanged position means frozen data (m/s). Ours."""

Read = Callable[[], "Surroundings | None"]
"""Returns the stack's surroundings, or None if there are none."""


@dataclass(frozen=True)
class _RawSample:
    now_s: float
    raw: Surroundings
    controls: tuple[TrafficControl, ...]


class SurroundingsMonitor:
    """Monitor of the stack's surroundings. Every call requires the solver's own time.

    Args:
        controls: Numbers of the guard for lights and stop signs; the defaults if None.
    """

    def __init__(self, controls: ControlPolicy | None = None) -> None:
        self._controls = ControlMemory(controls)
        self._last: _RawSample | None = None
        self._fresh_s = -math.inf
        """Time at which the current frame was first returned (s)."""
        self._jumped_s = -math.inf
        self._trusted: EgoState | None = None
        self._trusted_s = 0.0
        self._seen: dict[str, tuple[TrackedObject, float]] = {}
        self._fault_s = -math.inf
        self.fault: str | None = None
        """Current fault, in a few words."""

    def look(self, read: Read, now_s: float, clock_s: float | None = None) -> Surroundings | None:
        """Return the surroundings at this tick, or None if there never were any.

        Args:
            read: Returns the stack's surroundings.
            now_s: The solver's own time (s).
            clock_s: The stack's time (s), for comparison with the time of the surroundings; None: no comparison.
        """
        raw, why = _read(read)
        if raw is None:
            return self._missing(now_s, why)
        age, fault = self._age(raw, now_s)
        behind_s = 0.0 if clock_s is None else min(now_s - raw.time_s, clock_s - raw.time_s, key=abs)
        if abs(behind_s) > max(raw.age_s, FROZEN_TELL_S):
            age = max(age, abs(behind_s))
        self._show(fault or "; ".join(raw.sensor_faults) or _late(raw.age_s, behind_s), now_s)
        ego = self._trusted_ego(raw.ego, now_s, jumped=age == DOUBTFUL_AGE_S)
        objects = self._with_vanished(raw.objects, now_s)
        # Without a reliable position of the ego, no line has a position.
        controls = raw.controls if age == DOUBTFUL_AGE_S else self._controls.controls(raw)
        self._last = _RawSample(now_s, raw, controls)
        if age == raw.age_s and objects is raw.objects and controls is raw.controls:
            return raw
        return raw.model_copy(update={"age_s": age, "objects": objects, "ego": ego, "controls": controls})

    def blind_s(self, now_s: float) -> float:
        """Return the time since the last new surroundings (s)."""
        return now_s - self._fresh_s

    def _show(self, fault: str | None, now_s: float) -> None:
        """Set the fault. It keeps its text while it lasts, although its numbers may change on each tick."""
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

    def _age(self, raw: Surroundings, now_s: float) -> tuple[float, str | None]:
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

    def _trusted_ego(self, ego: EgoState, now_s: float, *, jumped: bool) -> EgoState:
        """Return the ego; right after a jump it is extrapolated from the last reliable position.

        A position reached only by a jump must not prove that a plan has passed its commit point.
        """
        before, passed = self._trusted, now_s - self._trusted_s
        self._trusted_s = now_s
        if jumped and before is not None:
            driven = ego.speed_mps * max(passed, 0.0)
            x, y = before.x_m + driven * math.cos(before.yaw_rad), before.y_m + driven * math.sin(before.yaw_rad)
            ego = before.model_copy(update={"x_m": x, "y_m": y, "speed_mps": ego.speed_mps})
        self._trusted = ego
        return ego

    def _with_vanished(self, objects: tuple[TrackedObject, ...], now_s: float) -> tuple[TrackedObject, ...]:
        """Return the present objects and those that vanished a short time ago.

        A tracker that reports the uncertainty of positions has its own memory: it keeps occluded objects, and ends a
        track after it has observed the position often enough. Only vulnerable road users are kept for longer here.
        """
        latest = self._seen
        for o in objects:
            latest[o.id] = (o, now_s)
        if len(latest) == len(objects):
            return objects
        vanished: list[TrackedObject] = []
        for name, (o, when) in list(latest.items()):
            if when == now_s:
                continue
            is_remembered = o.position_sd_m is not None and o.kind not in VULNERABLE
            if 0.0 <= now_s - when <= HOLD_S + SAME_S and not is_remembered:
                vanished.append(_extrapolated(o, now_s - when))
            else:
                del latest[name]
        return (*objects, *vanished) if vanished else objects


def _read(read: Read) -> tuple[Surroundings | None, str]:
    """Return the stack's surroundings, or None with the reason if they are unusable. Catches any error of the stack."""
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
    """Return the constant part of the text of a fault."""
    return re.sub(r"[-+.\d]+", "", fault.split(" is ")[0])


def _late(age_s: float, behind_s: float) -> str | None:
    """Return the fault in the age of surroundings, with the remedy; None if they are new enough."""
    if age_s > FROZEN_TELL_S:
        oldest = f"no plan begins on data older than {FROZEN_TELL_S:g} s"
        return f"surroundings.age_s is {age_s:.1f} s: {oldest}; give newer data"
    if abs(behind_s) > FROZEN_TELL_S:
        relation = "behind" if behind_s > 0.0 else "ahead of"
        remedy = "stamp both from one clock, or give the age of the data in age_s"
        return f"surroundings.time_s is {abs(behind_s):.1f} s {relation} status.time_s; {remedy}"
    return None


def _unchanged(last: Surroundings, raw: Surroundings) -> str:
    """Return the fault of surroundings that have been unchanged for too long."""
    if last.frame == raw.frame and last.time_s != raw.time_s:
        return f"surroundings.frame is {raw.frame} for {FROZEN_TELL_S:g} s; give new data another number"
    return f"the same frame for {FROZEN_TELL_S:g} s"


def _same(first: Surroundings, second: Surroundings) -> bool:
    """True for the same frame: the same number, or a moving ego or moving objects with unchanged positions."""
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
    """Return the distance of the position from all positions that the speed allows (m)."""
    moved = math.hypot(after.x_m - before.x_m, after.y_m - before.y_m)
    return moved - max(abs(before.speed_mps), abs(after.speed_mps)) * dt_s


def _extrapolated(o: TrackedObject, dt_s: float) -> TrackedObject:
    return o.model_copy(update={"x_m": o.x_m + o.vx_mps * dt_s, "y_m": o.y_m + o.vy_mps * dt_s})
