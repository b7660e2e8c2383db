"""Measures the code: `python -m lab.house [--root CHECKOUT] [--walks]`.

It prints one row for each package (files, lines, medians, shares of documented and one-word names ...). With `--walks`,
it also prints the number of files, functions and hops between files of one tick of the solver. The ticks are an
uneventful status, a tick that queries a reasoner, one that accepts a plan, one of a running plan, and one that rejects
a plan. It also measures earlier checkouts, whose packages are below `src`.
"""

from __future__ import annotations

import argparse
import ast
import statistics
import subprocess
import sys
import tokenize
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
"""Root of the repository."""
HEAD = (
    "package",
    "files",
    "lines",
    "median",
    "functions",
    "median",
    "doc %",
    "comment %",
    "Any",
    "one-word %",
    "twice",
    "const/kl",
)


@dataclass
class Package:
    """Counts of one package."""

    lines: list[int] = field(default_factory=list)
    """Lines of each file."""
    functions: list[int] = field(default_factory=list)
    """Lines of each function."""
    documented: int = 0
    """Number of documented public functions and classes."""
    public: int = 0
    """Number of public functions and classes."""
    comments: int = 0
    """Number of comments."""
    any_types: int = 0
    """Number of annotations with `Any`."""
    one_word: int = 0
    """Number of names of one word."""
    constants: int = 0
    """Number of constants."""
    classes: Counter[str] = field(default_factory=Counter)

    def row(self, name: str) -> tuple[str, ...]:
        """Return the cells of its row."""
        total, functions = sum(self.lines), len(self.functions)
        twice = sum(count > 1 for count in self.classes.values())
        return (
            name,
            f"{len(self.lines)}",
            f"{total}",
            f"{statistics.median(self.lines):.0f}",
            f"{functions}",
            f"{statistics.median(self.functions or [0]):.0f}",
            f"{100 * self.documented / max(self.public, 1):.0f}",
            f"{100 * self.comments / total:.1f}",
            f"{self.any_types}",
            f"{100 * self.one_word / max(functions, 1):.0f}",
            f"{twice}",
            f"{1000 * self.constants / total:.0f}",
        )


def package_of(path: Path) -> str | None:
    """Return the package to which a file belongs, `tests` for tests, or None for files that are not counted."""
    parts = path.parts
    if "tests" in parts:
        return "tests"
    if "src" in parts:
        return parts[parts.index("src") + 1]
    return "lab" if parts[0] in ("lab", "benchmarks", "training", "docsite", "releasing") else None


def measure(root: Path) -> dict[str, Package]:
    """Count everything in a checkout, by package."""
    found: dict[str, Package] = defaultdict(Package)
    listed = subprocess.run(["git", "ls-files", "-z", "*.py"], cwd=root, capture_output=True, text=True, check=True)
    for name in filter(None, listed.stdout.split("\0")):
        package = package_of(Path(name))
        if package is not None and (root / name).is_file():
            _count(found[package], root / name)
    return dict(sorted(found.items()))


def _count(package: Package, path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    package.lines.append(text.count("\n"))
    with path.open("rb") as file:
        package.comments += sum(token.type == tokenize.COMMENT for token in tokenize.tokenize(file.readline))
    tree = ast.parse(text)
    for statement in tree.body:
        if isinstance(statement, ast.ClassDef):
            package.classes[statement.name] += 1
        if isinstance(statement, ast.Assign | ast.AnnAssign):
            targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            numbers = any(
                isinstance(part, ast.Constant) and isinstance(part.value, int | float) for part in ast.walk(statement)
            )
            names = [target.id for target in targets if isinstance(target, ast.Name)]
            package.constants += numbers * sum(name.isupper() for name in names)
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            package.functions.append((node.end_lineno or node.lineno) - node.lineno + 1)
            package.one_word += "_" not in node.name.strip("_")
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            package.public += 1
            package.documented += ast.get_docstring(node) is not None
        package.any_types += isinstance(node, ast.Name) and node.id == "Any"


def table(rows: list[tuple[str, ...]]) -> str:
    """Return rows as a table in Markdown; the first one is its head."""
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join([lines[0], "|" + "---|" * len(rows[0]), *lines[1:]])


# ---- walks: the code of one tick


@dataclass
class Walk:
    """Files, functions and changes of file in one call."""

    files: set[str] = field(default_factory=set)
    functions: set[tuple[str, str]] = field(default_factory=set)
    hops: int = 0


def walked(call: Callable[[], Any]) -> Walk:
    """Return the product's own code that a call runs."""
    walk, stack = Walk(), [""]

    def profile(frame: Any, event: str, _: object) -> None:
        file = frame.f_code.co_filename
        ours = "/src/stucksolver/" in file and not frame.f_code.co_name.startswith("<")
        if event == "call" and ours:
            walk.files.add(file)
            walk.functions.add(
                (file, frame.f_code.co_qualname if sys.version_info >= (3, 11) else frame.f_code.co_name)
            )
            walk.hops += stack[-1] != file
            stack.append(file)
        elif event == "return" and ours and len(stack) > 1:
            stack.pop()

    sys.setprofile(profile)
    try:
        call()
    finally:
        sys.setprofile(None)
    return walk


def walks(root: Path) -> Iterator[tuple[str, Walk]]:
    """Drive the small test world past a parked car and up to a truck, and yield each kind of tick once.

    Raises:
        LookupError: The checkout has no test world.
    """
    helpers = next((path for path in (root / "packages/stucksolver/tests", root / "tests/core") if path.is_dir()), None)
    if helpers is None:
        raise LookupError(f"{root}: expected a checkout of this repository")
    sys.path.insert(0, str(helpers))
    from stucksolver.scene import LineKind, ObjectKind
    from worlds import World, straight_road, thing  # type: ignore[import-not-found]

    found = dict[str, Walk]()
    free, solid = straight_road(left=LineKind.BROKEN), straight_road(oncoming=LineKind.SOLID)
    for road, kind in ((free, ObjectKind.CAR), (solid, ObjectKind.TRUCK)):
        for name, walk in _ticks(World(road, [thing("blocker", 62.0, kind=kind, hazard=True)], speed=8.0)):
            found.setdefault(name, walk)
    yield from found.items()


def _ticks(world: Any) -> Iterator[tuple[str, Walk]]:
    """Drive a world with a solver, and yield every tick whose kind has a name."""
    from stucksolver.solver import EventKind, StuckSolver

    events: list[Any] = []
    directives: list[Any] = []
    with StuckSolver(world.scene, on_event=events.append, clock="lockstep") as solver:

        def step() -> None:
            directives.append(solver.step(world.status(), world.surroundings))

        for _ in range(1200):
            before, running = len(events), bool(directives) and type(directives[-1]).__name__ == "Execute"
            walk = walked(step)
            new = events[before:]
            verdicts = [event.verdict for event in new if event.kind is EventKind.DECIDED and event.verdict is not None]
            if verdicts:
                yield "first plan" if verdicts[0].accepted else "rejection", walk
            elif any(event.kind is EventKind.TRIGGERED for event in new):
                yield "query", walk
            elif not new:
                yield "running plan" if running else "status", walk
            world.drive(directives[-1])


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(prog="python -m lab.house", description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--root", type=Path, default=ROOT, help="checkout to measure (default: this one)")
    parser.add_argument("--walks", action="store_true", help="also trace ticks; import the packages of that checkout")
    options = parser.parse_args()
    packages = measure(options.root.resolve())
    code = sum(sum(package.lines) for name, package in packages.items() if name != "tests")
    print(table([HEAD, *(package.row(name) for name, package in packages.items())]))
    print(f"\n{code} lines without tests; {sum(packages['tests'].lines) / code:.2f} lines of tests per line")
    if options.walks:
        rows = [
            (name, f"{len(w.files)}", f"{len(w.functions)}", f"{w.hops}") for name, w in walks(options.root.resolve())
        ]
        print("\n" + table([("tick", "files", "functions", "hops"), *rows]))


if __name__ == "__main__":
    main()
