"""Times the steps of a newcomer, from the clone to a stack of one's own: `python -m lab.docsite.stopwatch`.

It clones this checkout's last commit into a temporary folder, sets it up with `make demo`, and runs every command of
the tutorial there, in the environment that `make demo` made. The times go into the table of `docs/tutorial/index.md`.
Reading and typing are not counted, and neither is the download of the repository, because the clone is a local one.
"""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from datetime import date
from pathlib import Path
from typing import NamedTuple

from lab.docsite.diagrams import ROOT
from lab.docsite.tutorials import follow

INDEX = ROOT / "docs" / "tutorial" / "index.md"
TABLE = re.compile(r"(?<=<!-- stopwatch -->\n).*?(?=<!-- /stopwatch -->)", re.DOTALL)
STEPS = {
    "first-recovery": "first recovery",
    "own-route": "your own route",
    "own-stack": "your own stack",
    "own-model": "your own model",
    "own-behavior": "your own behavior",
}
ENDING = " 2>&1 || true"
"""End of commands that are meant to fail; the table leaves it out."""


class Lap(NamedTuple):
    """One step: its purpose, the last of its commands, and their duration (s)."""

    step: str
    command: str
    seconds: float


def laps(folder: Path) -> Iterator[Lap]:
    """Do all steps in an empty folder.

    Raises:
        CalledProcessError: A command fails.
        TutorialError: A page does not do what it says.
    """
    clone = folder / "stucksolver"
    yield _timed("clone", ["git", "clone", "--quiet", str(ROOT), str(clone)], folder)
    yield _timed("environment, and the demo", ["make", "demo"], clone)
    python = str(clone / ".venv" / "bin" / "python")
    for page, step in STEPS.items():
        text = (clone / "docs" / "tutorial" / f"{page}.md").read_text(encoding="utf-8")
        begun = time.monotonic()
        for commands in follow(text, clone, page, python):
            now = time.monotonic()
            yield Lap(step, commands.splitlines()[-1], now - begun)
            begun = now


def _timed(step: str, command: list[str], folder: Path) -> Lap:
    begun = time.monotonic()
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    shown = "git clone URL" if command[0] == "git" else " ".join(command)
    return Lap(step, shown, time.monotonic() - begun)


def table(found: list[Lap]) -> str:
    """Return the Markdown table; its last column adds up the times."""
    lines = ["", "| step | command | time | since the start |", "|---|---|---|---|"]
    total, last = 0.0, ""
    for lap in found:
        total += lap.seconds
        command = lap.command.removesuffix(ENDING)
        lines.append(
            f"| {lap.step if lap.step != last else ''} | `{command}` | {lap.seconds:.0f} s | {total / 60:.1f} min |"
        )
        last = lap.step
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.strip()
    where = f"{os.cpu_count()} cores, Python {platform.python_version()}, commit {commit}, {date.today()}"
    return "\n".join([*lines, "", f"`python -m lab.docsite.stopwatch`, {where}.", ""])


def main() -> int:
    """Time all steps, and write the table."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for lap in laps(Path(folder)):
            print(f"{lap.seconds:6.1f} s  {lap.step}: {lap.command}", flush=True)
            found.append(lap)
    text = INDEX.read_text(encoding="utf-8")
    INDEX.write_text(TABLE.sub(lambda _: table(found), text, count=1), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
