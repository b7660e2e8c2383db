"""Infractions that scenarios report: too slow (ScenarioTimeoutTest), no yield to an emergency vehicle (YieldTo...)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from stucksolver_eval.criteria.criterion import Criterion, EgoTick, Infraction

_KINDS = {"scenario_timeout": "scenario_timeouts", "yield_emergency_vehicle": "yield_emergency_vehicle_infractions"}


class _Event(Protocol):
    @property
    def time_s(self) -> float: ...
    @property
    def kind(self) -> str: ...
    @property
    def text(self) -> str: ...
    @property
    def value(self) -> float: ...


class ScenarioEvents(Criterion):
    """Reads a play's growing list of events."""

    kind = "scenario_events"

    def __init__(self, events: Sequence[_Event]) -> None:
        super().__init__()
        self._events = events
        self._read = 0

    def update(self, moment: EgoTick) -> None:
        for event in self._events[self._read :]:
            kind = _KINDS.get(event.kind)
            gave_way = event.kind == "yield_emergency_vehicle" and event.value > 0.0
            if kind is not None and not gave_way:
                self.infractions.append(Infraction(kind, event.time_s, event.text))
        self._read = len(self._events)
