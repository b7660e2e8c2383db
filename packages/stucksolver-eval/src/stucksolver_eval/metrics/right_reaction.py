"""Judges whether the ego did what a situation requires in time, from the outcome of its drive alone.

Times count from the ego's arrival (mark `met`):

- **recover**: it passed in time.
- **ask**: an operator was told why it stands, or was called, in time, and it did not pass.
- **leave**: it left the place where it may not stop in time.
- **reroute**: it reached its destination another way in time.
- **wait**: it neither passed nor moved by a plan before going became right (mark `free`), and passed in time after it.

An infraction after the arrival is always wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from statistics import median

from stucksolver_eval.results.outcome import RouteOutcome

NOT_HARM = frozenset({"min_speed_infractions", "vehicle_blocked", "route_timeout", "scenario_timeouts"})
"""Infractions without harm."""
END_M = 25.0
"""Distance before the route's end at which the ego counts as arrived (m).

A route is over 10 m before its end. Its track has one position per second, and at 50 km/h there are 14 m between them.
"""
HEAD = ("Situation", "Right reaction", "Done", "Passenger told after s", "Operator told after s", "What was wrong")


@dataclass(frozen=True)
class TypeRow:
    """The judgments of a type's drives.

    `told_s` and `called_s` are median times from the arrival until a passenger and an operator are told why the ego
    stands. A call for help tells an operator, too.
    """

    scenario: str
    reaction: str
    right: int
    drives: int
    told_s: float | None
    called_s: float | None
    faults: tuple[str, ...]

    @property
    def cells(self) -> tuple[str, ...]:
        """The row in the order of `HEAD`."""
        done, times = f"{self.right}/{self.drives}", map(_seconds, (self.told_s, self.called_s))
        return self.scenario, self.reaction, done, *times, "; ".join(self.faults) or "–"

    @property
    def text(self) -> str:
        """The row as a line."""
        told = "passenger not told" if self.told_s is None else f"passenger told after {self.told_s:.0f} s"
        called = "operator not told" if self.called_s is None else f"operator told after {self.called_s:.0f} s"
        faults = "".join(f"; {fault}" for fault in self.faults)
        return f"{self.right}/{self.drives} {self.scenario} ({self.reaction}): {told}, {called}{faults}"


def fault_of(o: RouteOutcome) -> str:
    """Return what was wrong with the reaction, for people; empty if it was right.

    Raises:
        KeyError: The outcome states no reaction.
    """
    met_s = o.marks.get("met")
    if met_s is None:
        return "never arrived"
    harm = next((item for item in o.infractions if item.kind not in NOT_HARM and item.time_s >= met_s), None)
    if harm is not None:
        return f"{harm.kind} after {harm.time_s - met_s:.0f} s"
    return _FAULTS[o.expected or ""](o, met_s, o.within_s or 0.0)


def _recover(o: RouteOutcome, met_s: float, within_s: float) -> str:
    return _late("passed", o.marks.get("passed"), met_s, within_s)


def _leave(o: RouteOutcome, met_s: float, within_s: float) -> str:
    return _late("left", o.marks.get("left"), met_s, within_s)


def _reroute(o: RouteOutcome, met_s: float, within_s: float) -> str:
    arrived = (time_s for time_s, place_m in o.track if place_m >= o.length_m - END_M)
    return _late("at the destination", next(arrived, None), met_s, within_s)


def _ask(o: RouteOutcome, met_s: float, within_s: float) -> str:
    if "passed" in o.marks:
        return f"passed after {o.marks['passed'] - met_s:.0f} s"
    after_s = called_after_s(o)
    return _late("told an operator", None if after_s is None else met_s + after_s, met_s, within_s)


def _wait(o: RouteOutcome, met_s: float, within_s: float) -> str:
    free_s = o.marks.get("free", float("inf"))
    moved_s = next((item.start_s for item in o.interventions if item.moves and met_s <= item.start_s < free_s), None)
    if o.marks.get("passed", float("inf")) < free_s:
        return f"passed after {o.marks['passed'] - met_s:.0f} s"
    if moved_s is not None:
        return f"moved after {moved_s - met_s:.0f} s"
    return _late("passed once it was free", o.marks.get("passed"), free_s, within_s)


_FAULTS: Mapping[str, Callable[[RouteOutcome, float, float], str]] = {
    "recover": _recover,
    "leave": _leave,
    "reroute": _reroute,
    "ask": _ask,
    "wait": _wait,
}


def _late(done: str, time_s: float | None, from_s: float, within_s: float) -> str:
    if time_s is None:
        return f"never {done}"
    return "" if time_s - from_s <= within_s else f"{done} after {time_s - from_s:.0f} s"


def called_after_s(o: RouteOutcome) -> float | None:
    """Return the time from the arrival until an operator is told or called (s); None if either did not happen."""
    return _first_after_s(o, *_notices_s(o, "operator"), *(() if o.asked_s is None else (o.asked_s,)))


def told_after_s(o: RouteOutcome) -> float | None:
    """Return the time from the arrival until a passenger is told why the ego stands (s); None without a notice."""
    return _first_after_s(o, *_notices_s(o, "passenger"))


def _notices_s(o: RouteOutcome, to: str) -> list[float]:
    return [notice.time_s for notice in o.notices if notice.to == to]


def _first_after_s(o: RouteOutcome, *times_s: float) -> float | None:
    """Return the time from the arrival to the first of these; what came before counts as at the arrival."""
    met_s = o.marks.get("met")
    return None if met_s is None or not times_s else max(min(times_s) - met_s, 0.0)


def type_rows(outcomes: Iterable[RouteOutcome]) -> list[TypeRow]:
    """Return a row for each type whose reaction has a time limit."""
    groups: dict[str, list[RouteOutcome]] = {}
    for outcome in outcomes:
        if outcome.within_s is not None and outcome.state == "driven":
            groups.setdefault(outcome.scenario, []).append(outcome)
    return [_type_row(name, drives) for name, drives in sorted(groups.items())]


def _type_row(name: str, drives: list[RouteOutcome]) -> TypeRow:
    faults = [fault for fault in map(fault_of, drives) if fault]
    return TypeRow(
        scenario=name,
        reaction=f"{drives[0].expected} within {drives[0].within_s:.0f} s",
        right=len(drives) - len(faults),
        drives=len(drives),
        told_s=_median(map(told_after_s, drives)),
        called_s=_median(map(called_after_s, drives)),
        faults=tuple(dict.fromkeys(faults)),
    )


def _median(times_s: Iterable[float | None]) -> float | None:
    known = [time_s for time_s in times_s if time_s is not None]
    return median(known) if known else None


def _seconds(time_s: float | None) -> str:
    return "–" if time_s is None else f"{time_s:.0f}"
