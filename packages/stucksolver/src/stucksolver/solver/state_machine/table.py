"""The table of states and transitions, from which `docs/states.md` is generated.

    python -m stucksolver.solver.state_machine.table > docs/states.md

`packages/stucksolver/tests/test_machine.py` drives the machine at random and checks that it takes each of these
transitions and no other.
"""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from enum import Enum
from typing import TypeVar

from stucksolver.solver.state_machine import execution_phases
from stucksolver.solver.state_machine.hand_back import FREE_S, HOLD_S, LONGEST_HOLD_S, MOVED_M, SETTLES_S
from stucksolver.solver.state_machine.human_in_the_loop import AHEAD_M
from stucksolver.solver.state_machine.state import StateName

S = StateName
N = TypeVar("N", bound=Enum)
ACTIVITIES: dict[tuple[StateName, StateName], str] = {
    (S.MONITORING, S.QUERYING): "a trigger or words, and a reasoner is due on the ladder",
    (S.MONITORING, S.EXECUTING): "on the last rung, the guard accepts a way to a place to stand",
    (S.QUERYING, S.QUERYING): "the plan is refused, and the reasoner is told why; or new words ask for something else",
    (S.QUERYING, S.AWAITING_APPROVAL): "the plan lacks only the yes of a person",
    (S.QUERYING, S.AWAITING_GAP): "only traffic speaks against the plan",
    (S.QUERYING, S.EXECUTING): "the guard accepts the plan",
    (S.QUERYING, S.MONITORING): "waiting is right, there is no plan or no answer, it is refused, or the way is free",
    (S.AWAITING_APPROVAL, S.EXECUTING): "somebody says yes, and the guard accepts the plan as things stand now",
    (S.AWAITING_APPROVAL, S.AWAITING_GAP): "somebody says yes, and now only traffic speaks against the plan",
    (S.AWAITING_APPROVAL, S.QUERYING): "the plan is refused in spite of the yes; or words ask for something else",
    (S.AWAITING_APPROVAL, S.MONITORING): "somebody says no, nobody answers in time, or the way is free",
    (S.AWAITING_GAP, S.EXECUTING): "the guard accepts the plan: here is the gap",
    (S.AWAITING_GAP, S.QUERYING): "words ask for something else",
    (S.AWAITING_GAP, S.MONITORING): "time is over, something else speaks against the plan, or the way is free",
    (S.EXECUTING, S.MONITORING): "the plan is done, or given up",
    (S.EXECUTING, S.AWAITING_GAP): "given up for traffic before 2 m of it were driven",
}
POSTURES: dict[tuple[StateName, StateName], str] = {
    (S.DRIVING, S.HOLDING): "a plan ends where the driver's next second is not clear, or the driver is about to touch "
    "something after a hand-back",
    (S.DRIVING, S.MINIMAL_RISK): "the last rung, behind what blocks the path, at a place where the vehicle may stop",
    (S.HOLDING, S.DRIVING): "the driver's next second is clear, nothing has been seen for 5 s, a plan begins, or the "
    "limit of the hold",
    (S.HOLDING, S.MINIMAL_RISK): "the last rung, behind what blocks the path, at a place where the vehicle may stop",
    (S.MINIMAL_RISK, S.DRIVING): "the operator's yes, a free way, a plan, or the limit of the stop: see the next table",
    (S.MINIMAL_RISK, S.HOLDING): "the operator's yes, for a vehicle that was held before",
}
HELD: tuple[tuple[str, str, str], ...] = (
    (
        f"an object stands in the route's path, less than {AHEAD_M:g} m ahead",
        "minimal risk condition, once in an intervention, on the last rung",
        f"it is gone or has moved on by {MOVED_M:g} m and the driver's next second is clear, both for {FREE_S:g} s, "
        f"or the operator's yes, or a plan, as `resume` says; in any case after {HOLD_S:g} s. "
        "If `resume` is `operator`: only the operator's yes",
    ),
    ("nothing stands there, or nothing is known", "nothing is held: help is called, and the driver drives", "–"),
    (
        "the vehicle may not stop here",
        "nothing is held: help is called, and a way to a place to stop is looked for",
        "–",
    ),
    (
        "a plan calls for help (`request_assistance`)",
        "stopped as part of the plan",
        "the path is free for 25 m, or the time that the plan gives is over (5 to 300 s)",
    ),
    (
        "a plan has ended, and the driver's next second is not clear, or the way back into the lane is not",
        "holding",
        f"it is clear; a plan begins; nothing has been seen for 5 s; the limit of {HOLD_S:g} s",
    ),
    (
        "the driver drives after a plan, stop or hold, and is about to touch something",
        "holding, with the brakes on hard",
        f"as above, but not before {SETTLES_S:g} s; the limit doubles each time, up to {LONGEST_HOLD_S:g} s",
    ),
    ("a status with a value that is not a number", "the same as on the tick before", "the next valid status"),
)
"""Everything that keeps the vehicle from its driver: the reason, what happens, and when that ends."""


def page() -> str:
    """Return the whole page in Markdown."""
    return f"""# The solver's states

Made by `python -m stucksolver.solver.state_machine.table > docs/states.md`.

`StuckSolver.step` is a shell around one pure function, `transition(state, inputs, setup)`. It maps a state and a tick's
inputs to the next state, the directive, and the events. A state has two concurrent parts: an activity, and what the
vehicle does while no plan is executed. While a plan is executed, the second part is always
`{S.DRIVING.value}`.

| state | what it means |
|---|---|
{_meanings(StateName)}

```mermaid
stateDiagram-v2
{_diagram(ACTIVITIES)}
```

{_table(ACTIVITIES)}

```mermaid
stateDiagram-v2
{_diagram(POSTURES)}
```

{_table(POSTURES)}

## The phases of a running plan

While a plan is executed, `Execution.phase` says what it does. Every phase may also end the plan. The checks of the
core's tests fail if an execution takes a transition that is not in the second table.

| phase | what it means |
|---|---|
{_meanings(execution_phases.PhaseName)}

```mermaid
stateDiagram-v2
{_diagram(execution_phases.TRANSITIONS)}
```

{_table(execution_phases.TRANSITIONS)}

## What holds the vehicle, and when that ends

Whatever holds the vehicle has a reason that can be seen, and ends with it. It also ends by itself after a time, since
the driver alone might go on. From the first hand-back of an intervention to its end, the guard brakes for the driver
at the last moment at which a stop still helps, so that it may be left to drive (`guard/hand_back.py`).

{_held()}

An intervention begins with the first answer that is not a legitimate wait. It is closed when the vehicle has made its
way (`hand_back.progress_m` of the ladder) with nothing and nobody being waited for. The place on the ladder, the
passenger's words, an open question to a person, and what has failed are further fields of the state
(`stucksolver.solver.state_machine.state.State`).
"""


def _meanings(names: type[Enum]) -> str:
    """The explanation below each name."""
    source = inspect.getsource(names)
    rows = []
    for item in names:
        after = source.split(f'{item.name} = "{item.value}"', 1)[1]
        rows.append(f"| {item.value} | {after.split(chr(34) * 3)[1]} |")
    return "\n".join(rows)


def _held() -> str:
    rows = [f"| {' | '.join(row)} |" for row in HELD]
    return "\n".join(["| reason | what happens | it ends when |", "|---|---|---|", *rows])


def _diagram(rows: Mapping[tuple[N, N], str]) -> str:
    return "\n".join(f"    {row.name.lower()} --> {other.name.lower()}" for row, other in rows)


def _table(rows: Mapping[tuple[N, N], str]) -> str:
    lines = [f"| {row.value} | {other.value} | {why} |" for (row, other), why in rows.items()]
    return "\n".join(["| from | to | when |", "|---|---|---|", *lines])


if __name__ == "__main__":
    print(page(), end="")
