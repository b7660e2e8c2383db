"""Writes the page of results."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable
from pathlib import Path

from lab.benchmarks.mutation.results import KILLED, SURVIVED, UNREACHED, Result, read, write
from lab.benchmarks.mutation.run import ROOT, all_mutants, sources
from lab.benchmarks.mutation.session import is_general

PAGE = ROOT / "results" / "mutation.md"
STORED = ROOT / "results" / "mutation" / "mutants.tsv"
BOUNDARY = "boundary"
MEANINGS = {
    "arithmetic": "another operator between two numbers or masks",
    "comparison": "the opposite comparison",
    BOUNDARY: "a bound that is inclusive, or no longer is",
    "constant": "another number, or the other truth value, in a function",
    "bound": "a named constant or a field of the policy, larger and smaller by a quarter",
    "operand dropped": "one condition less in `and` or `or`",
    "and/or": "`and` for `or`, and the other way round",
    "function": "`min` for `max`, `any` for `all`, `sin` for `cos`, and the like",
    "early return": "a return, `continue` or `break` that is never taken",
    "sign": "without a `-`, `not` or `~`",
    "branches swapped": "the branches of a conditional expression change places",
    "left out": "a call for its effect, or an addition, left out",
    "abs": "without `abs`",
    "negated": "a condition the other way round",
    "order": "two elements of a returned tuple change places",
    "element dropped": "one element less in a set of kinds",
}


def write_page(found: Path) -> None:
    """Write the page, and store the results next to it. Results of lines that no longer exist are left out."""
    results = read(found)
    files = sources()
    listed = {(name, mutant.line, mutant.kind, mutant.change(files[name])) for name, mutant in all_mutants(files)}
    present = [result for result in results if result.key in listed]
    if not present:
        raise SystemExit(f"error: no result belongs to a line of the present sources: {found}. Run the mutants again")
    write(STORED, present)
    PAGE.write_text(page(present, len(listed), len(results) - len(present)), encoding="utf-8")


def page(results: list[Result], listed: int, outdated: int) -> str:
    """Return the page's text.

    Args:
        results: The results of mutants of the present sources.
        listed: Number of mutants of the present sources.
        outdated: Number of results whose line has changed since.
    """
    counts = _counts(results)
    alive = [result for result in results if result.outcome != KILLED]
    other = [item for item in alive if item.kind != BOUNDARY]
    missing = listed - len(results)
    left = f" {missing} of {listed} mutants of the present sources have no result." if missing else ""
    old = f" {outdated} results belong to lines that have changed since, and are left out." if outdated else ""
    cut = sum(result.outcome == SURVIVED and result.ran < result.reaching for result in results)
    return f"""# Mutation testing of the guard and of the execution of plans

Each mutant changes one operator, bound, condition or early return of `guard/` or of what executes a plan in
`solver/state_machine/`, and runs the tests of `packages/stucksolver/tests` that reach its line until one fails: those
that state a promise first, stored verdicts and random worlds last. Every result is in
[mutation/mutants.tsv](mutation/mutants.tsv), a line each. Made by

    python3.12 -m lab.benchmarks.mutation run --limit-s 5 --out OUT
    python3.12 -m lab.benchmarks.mutation page OUT/mutants.tsv

| | mutants | share |
|---|---|---|
| run | {len(results)} | |
| killed by a test that states a promise | {_share(counts["promise"], len(results))} |
| killed only by stored verdicts or random worlds | {_share(counts["general"], len(results))} |
| alive, and change only whether a bound is inclusive | {_share(len(alive) - len(other), len(results))} |
| alive, others | {_share(len(other), len(results))} |
| of these, no test runs the line | {_share(sum(item.outcome == UNREACHED for item in other), len(results))} |

Killed counts those after which the tests no longer end ({counts["time"]}) or the process breaks ({counts["died"]}).
Of those alive, {cut} ran only the quickest of the tests that reach them (`--limit-s`).{left}{old}

A mutant that only makes a bound inclusive differs if a measured value equals the bound to the last bit, and nothing is
promised about that case.

## By file

| file | mutants | killed | only by stored verdicts or random worlds | alive: inclusive | alive: others |
|---|---|---|---|---|---|
{_table(results, lambda result: result.file)}

## By change

| change | mutants | killed | only by stored verdicts or random worlds | alive: inclusive | alive: others |
|---|---|---|---|---|---|
{_table(results, lambda result: MEANINGS[result.kind])}
"""


def _share(count: int, of: int) -> str:
    return f"{count} | {100 * count / of:.0f} %"


def _how(result: Result) -> str:
    if result.outcome != KILLED:
        return "inclusive" if result.kind == BOUNDARY else "others"
    if result.by in ("time", "died"):
        return result.by
    return "general" if is_general(result.by) else "promise"


def _counts(results: Iterable[Result]) -> Counter[str]:
    return Counter(_how(result) for result in results)


def _table(results: list[Result], group: Callable[[Result], str]) -> str:
    groups: dict[str, list[Result]] = defaultdict(list)
    for result in results:
        groups[group(result)].append(result)
    rows = []
    for name, some in sorted(groups.items()):
        counts = _counts(some)
        killed = sum(item.outcome == KILLED for item in some)
        shown = f"`{name}`" if name.endswith(".py") else name
        rows.append(
            f"| {shown} | {len(some)} | {killed} | {counts['general']} | {counts['inclusive']} | {counts['others']} |"
        )
    return "\n".join(rows)
