"""Runs mutants against the tests that reach them, many at a time, and stops each at the first test that fails."""

from __future__ import annotations

import os
import pickle
import random
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import pytest

from lab.benchmarks.mutation import results
from lab.benchmarks.mutation.mutants import Mutant, mutants_of, reads
from lab.benchmarks.mutation.patch import Functions, import_instead
from lab.benchmarks.mutation.reach import Reach, reach_of
from lab.benchmarks.mutation.results import KILLED, SURVIVED, UNREACHED, Result
from lab.benchmarks.mutation.session import SLACK_S, SLOWER, Ended, Job, Session, collect, in_forks, say, short

ROOT = Path(__file__).resolve().parents[3]
"""Root of the repository."""
SOURCES = ROOT / "packages" / "stucksolver" / "src" / "stucksolver"
MACHINE = ("execution", "plan_lifecycle", "pending_transition", "gap_wait", "minimal_risk")
"""Modules in `solver/state_machine` that execute a plan."""
LIKELY = 8
"""Number of tests that run first: those that killed most other mutants of the file. Ours."""
FIRST = 40
"""Number of tests against which a change with its own import is first run. Ours.

Only the files of these tests are imported.
"""
NO_CHANGE = -1
"""Index that reports a change without an effect in memory."""
IMPORTS_S = 60.0
"""Limit of the CPU time of the import and the collection (s). Ours."""


@dataclass(frozen=True)
class Options:
    """Options of a run.

    Attributes:
        out: Folder of the results and of the lines that tests reach.
        processes: Number of mutants that run at the same time.
        limit_s: CPU time of a mutant's tests, in the run without a change, after which no more tests follow (s).
        for_s: Time after which no mutant begins (s).
        sample: Maximum number of mutants, drawn at random; 0 for all.
        again: Run survivors again.
        files: Only these files, below `packages/stucksolver/src/stucksolver`; all if empty.
        tests: Folder of the tests.
    """

    out: Path
    processes: int
    limit_s: float
    for_s: float
    sample: int
    again: bool
    files: tuple[str, ...]
    tests: tuple[str, ...]


def sources(files: Iterable[str] = ()) -> dict[str, bytes]:
    """Return the files to be changed, by their path below `packages/stucksolver/src/stucksolver`."""
    found = [
        *sorted((SOURCES / "guard").rglob("*.py")),
        *(SOURCES / "solver/state_machine" / f"{name}.py" for name in MACHINE),
    ]
    wanted = set(files)
    names = {str(path.relative_to(SOURCES)): path for path in found}
    if wanted - set(names):
        raise SystemExit(f"error: no such file among those to be changed: {', '.join(sorted(wanted - set(names)))}")
    return {name: path.read_bytes() for name, path in names.items() if not wanted or name in wanted}


def all_mutants(files: dict[str, bytes]) -> list[tuple[str, Mutant]]:
    """Return all mutants of these files."""
    return [(name, mutant) for name, source in files.items() for mutant in mutants_of(source)]


class Run:
    """One run of the tool, from the tests without a change to the last mutant."""

    def __init__(self, options: Options) -> None:
        self._options = options
        self._until_s = time.monotonic() + options.for_s
        self._files = sources(options.files)
        self._path = options.out / "mutants.tsv"
        self._reach_path = options.out / "reach.pickle"
        self._session = Session(self._collected)
        self._reach = Reach()
        self._names: list[str] = []
        self._killers: dict[str, Counter[int]] = defaultdict(Counter)

    def run(self) -> None:
        """Run everything. Finished parts in the same folder are not run again."""
        self._options.out.mkdir(parents=True, exist_ok=True)
        # The first part runs in a fork, so that this process never imports the modules that are changed.
        pid = os.fork()
        if not pid:
            code = 1
            try:
                collect([*self._options.tests], self._session)
                code = 0 if self._names else 1
            finally:
                os._exit(code)
        if os.waitpid(pid, 0)[1]:
            raise SystemExit("error: the tests cannot be collected. Run pytest on them alone")
        self._reach, self._names = pickle.loads(self._reach_path.read_bytes())
        todo = [(file, item) for file, item in self._todo() if item.imports]
        say(f"{len(todo)} changes of constants and defaults")
        self._keep(todo, self._cold)

    # ---- selection

    def _todo(self) -> list[tuple[str, Mutant]]:
        found = all_mutants(self._files)
        random.Random(1).shuffle(found)
        found = found[: self._options.sample] if self._options.sample else found
        again = self._options.again
        done = {item.key for item in results.read(self._path) if not again or item.outcome == KILLED}
        return [(file, item) for file, item in found if self._key(file, item) not in done]

    def _key(self, file: str, mutant: Mutant) -> tuple[str, int, str, str]:
        return file, mutant.line, mutant.kind, mutant.change(self._files[file])

    def _in_time(self, todo: list[tuple[str, Mutant]]) -> Iterator[tuple[str, Mutant]]:
        for item in todo:
            if time.monotonic() > self._until_s:
                say("the time is over. The same command continues")
                return
            yield item

    def _tests(self, file: str, mutant: Mutant) -> list[int]:
        """Return the tests that reach a change, in order."""
        if not mutant.imports:
            found = self._reach.tests(file, [mutant.lines])
            # A test that detected other changes of this file often detects this one as well.
            likely = [k for k, _ in self._killers[file].most_common(LIKELY) if k in found]
            return [*likely, *self._reach.in_order(found - set(likely), self._names)]
        if mutant.name is None:
            found = self._reach.tests(file, [(1, 10**4)])
        else:
            found = set[int]().union(*(self._reach.tests(path, [lines]) for path, lines in self._readers[mutant.name]))
        return self._reach.in_order(found, self._names)

    @cached_property
    def _readers(self) -> dict[str, set[tuple[str, tuple[int, int]]]]:
        """Statements that read a name or a field."""
        found: dict[str, set[tuple[str, tuple[int, int]]]] = defaultdict(set)
        for path in SOURCES.rglob("*.py"):
            for name, lines in reads(path.read_bytes()):
                found[name].add((str(path.relative_to(SOURCES)), lines))
        return found

    def _cut(self, tests: list[int]) -> tuple[list[int], float]:
        """Return the tests within the limit, and the CPU time that they may take (s)."""
        total = 0.0
        some: list[int] = []
        for k in tests:
            total += self._reach.took_s[k]
            if some and total > self._options.limit_s:
                break
            some.append(k)
        return some, SLACK_S + SLOWER * min(total, self._options.limit_s)

    # ---- in the process that has collected the tests

    def _collected(self, items: list[pytest.Item]) -> None:
        self._names = [short(item) for item in items]
        if len(set(self._names)) != len(self._names):
            raise SystemExit("error: two tests have the same file name and name")
        say(f"{len(items)} tests collected")
        self._find_reach(items)
        functions = Functions()
        todo = [(file, entry) for file, entry in self._todo() if not entry.imports]
        say(f"{len(todo)} changes of functions")
        self._keep(todo, lambda file, item: self._warm(file, item, items, functions))

    def _find_reach(self, items: list[pytest.Item]) -> None:
        if self._reach_path.exists():
            self._reach, names = pickle.loads(self._reach_path.read_bytes())
            if names == self._names:
                return
        began = time.monotonic()
        self._reach = reach_of(items, self._session, SOURCES, self._options.processes)
        for k in self._unreliable(items):
            self._reach.left_out[k] = "failed when it ran after others"
            del self._reach.took_s[k]
            for tests in self._reach.lines.values():
                tests.discard(k)
        for why, count in Counter(self._reach.left_out.values()).items():
            say(f"left out: {count} tests ({why})")
        for k, why in self._reach.left_out.items():
            if why != "skipped":
                say(f"  {why}: {self._names[k]}")
        total = sum(self._reach.took_s.values())
        say(f"{len(self._reach.took_s)} tests take {total:.0f} s of CPU; found in {time.monotonic() - began:.0f} s")
        self._reach_path.write_bytes(pickle.dumps((self._reach, self._names)))

    def _unreliable(self, items: list[pytest.Item]) -> list[int]:
        """Run all tests once more without a change, in the order and the way of mutants; return those that fail."""
        order = self._reach.in_order(self._reach.took_s, self._names)
        parts = max(len(order) // 40, 1)
        found = []
        jobs = []
        for part in range(parts):
            tests = order[part::parts]
            cpu_s = SLACK_S + SLOWER * sum(self._reach.took_s[k] for k in tests)
            jobs.append(Job(tests, lambda tests=tests: self._until_failed(tests, items, every=True), cpu_s))  # type: ignore[misc]
        for ended in in_forks(jobs, self._options.processes):
            if ended.how != "done":
                found += [k for k in ended.key if k not in [item[0] for item in ended.told]]
            found += [k for k, outcome, _ in ended.told if outcome == "failed"]
        return found

    def _until_failed(self, tests: list[int], items: list[pytest.Item], every: bool = False) -> Iterator[list[Any]]:
        """Run tests until one fails; yield the index, the outcome and the CPU time of each."""
        for k, after in zip(tests, [*tests[1:], None], strict=True):
            outcome, took_s = self._session.run(items[k], None if after is None else items[after])
            yield [k, outcome, took_s]
            if outcome == "failed" and not every:
                return

    def _warm(self, file: str, mutant: Mutant, items: list[pytest.Item], functions: Functions) -> Job:
        """Return a job that changes functions in this process's fork, and runs tests that were collected already."""
        tests = self._tests(file, mutant)
        some, cpu_s = self._cut(tests)

        def work() -> Iterator[list[Any]]:
            source = self._files[file]
            try:
                changed = functions.change(str(SOURCES / file), source, mutant.applied(source))
            except SyntaxError as error:
                # The changed source does not compile; the result says so.
                changed = 0
                yield [NO_CHANGE, str(error), 0.0]
            if not changed:
                yield [NO_CHANGE, "no function in memory has changed", 0.0]
                return
            yield from self._until_failed(some, items)

        return Job((file, mutant, len(tests), len(some)), work, cpu_s)

    # ---- constants and defaults: a process that has imported nothing yet

    def _cold(self, file: str, mutant: Mutant) -> Job:
        """Return a job that imports a changed source, then collects and runs tests."""
        tests = self._tests(file, mutant)
        some, cpu_s = self._cut(tests)

        def work() -> Iterator[list[Any]]:
            source = self._files[file]
            import_instead(SOURCES / file, mutant.applied(source))
            for part in (some[:FIRST], some[FIRST:]):
                if not part:
                    return
                messages = self._imported(part)
                yield from messages
                if messages[-1][1] == "failed":
                    return

        return Job((file, mutant, len(tests), len(some)), work, cpu_s + IMPORTS_S)

    def _imported(self, tests: list[int]) -> list[list[Any]]:
        """Collect the files of these tests and run the tests.

        A file that cannot be imported counts as a failed test.
        """
        messages: list[list[Any]] = []

        def serve(items: list[pytest.Item]) -> None:
            by_name = {short(item): item for item in items}
            wanted = [by_name[self._names[k]] for k in tests if self._names[k] in by_name]
            places = [k for k in tests if self._names[k] in by_name]
            for k, item, after in zip(places, wanted, [*wanted[1:], None], strict=True):
                outcome, took_s = session.run(item, after)
                messages.append([k, outcome, took_s])
                if outcome == "failed":
                    return

        session = Session(serve)
        files = sorted({self._names[k].split("::", 1)[0] for k in tests})
        folder = (
            self._options.tests[0]
            if Path(self._options.tests[0]).is_dir()
            else str(Path(self._options.tests[0]).parent)
        )
        collect([str(Path(folder) / file) for file in files], session)
        return messages or [[tests[0], "failed", 0.0]]

    # ---- results

    def _keep(self, todo: list[tuple[str, Mutant]], job_of: Callable[[str, Mutant], Job]) -> None:
        """Run mutants and add the result of each to the file at once."""
        counts: Counter[str] = Counter()
        began = time.monotonic()
        # A line that no test reaches requires no process.
        dead = [(file, item) for file, item in todo if not self._tests(file, item)]
        nobody = set(map(id, (item for _, item in dead)))
        jobs = (
            job_of(file, item) for file, item in self._in_time([pair for pair in todo if id(pair[1]) not in nobody])
        )
        with self._path.open("a", encoding="utf-8") as out:
            for file, item in dead:
                out.write(results.line_of(Result(*self._key(file, item), UNREACHED, "", 0, 0, 0.0)))
            counts[UNREACHED] += len(dead)
            for ended in in_forks(jobs, self._options.processes):
                result = self._result(ended)
                if result is None:
                    counts["not run"] += 1
                    continue
                out.write(results.line_of(result))
                out.flush()
                counts[result.outcome] += 1
                counts["cpu_s"] += round(result.took_s)
                if sum(counts.values()) % 200 == 0:
                    say(f"after {time.monotonic() - began:.0f} s: {dict(counts)} of {len(todo)}")
        say(f"after {time.monotonic() - began:.0f} s: {dict(counts)} of {len(todo)}")

    def _result(self, ended: Ended) -> Result | None:
        """Return a mutant's result; None if the change could not be put in place."""
        file, mutant, reaching, planned = ended.key
        messages = ended.told
        if messages and messages[0][0] == NO_CHANGE:
            say(f"{file}:{mutant.line} {mutant.kind}: {messages[0][1]}")
            return None
        failed = next((k for k, outcome, _ in messages if outcome == "failed"), None)
        if failed is not None:
            self._killers[file][failed] += 1
            outcome, by = KILLED, self._names[failed]
        elif ended.how != "done" or len(messages) < planned:
            # The change breaks the process itself, or the tests never end.
            outcome, by = KILLED, "died" if ended.how == "done" else ended.how
        else:
            outcome, by = SURVIVED, ""
        return Result(*self._key(file, mutant), outcome, by, len(messages), reaching, round(ended.took_s, 2))
