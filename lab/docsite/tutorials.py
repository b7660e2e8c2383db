"""Runs every file and command on the tutorial's pages: `python -m lab.docsite.tutorials [PAGE ...]`.

It works in a copy of the checkout, so that the pages may write and change files. A block with `title="NAME"` is a file.
`sh` blocks run in order, and the time of each is printed. Each line of a block titled "prints" must be in the output of
the commands before it.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from lab.docsite.diagrams import ROOT

PAGES = ROOT / "docs" / "tutorial"
BLOCK = re.compile(r'^```(\w+)(?: title="([^"]+)")?\n(.*?)^```$', re.MULTILINE | re.DOTALL)
CLONED = re.compile(r"packages/[^/]+/src/|packages/stucksolver-language/tests/llm/|examples/|docs/tutorial/")
"""Files that the pages use."""
PRINTS = "prints"
LIMIT_S = 600.0
"""Time limit for one block of commands (s). The longest drives two streets in about a minute on two idle cores."""


class Block(NamedTuple):
    """One fenced block of a page."""

    language: str
    title: str
    text: str


class TutorialError(RuntimeError):
    """A page does not do what it says."""


def blocks(page: str) -> list[Block]:
    """Return all blocks of a page that have a language."""
    return [Block(language, title or "", text) for language, title, text in BLOCK.findall(page)]


def follow(page: str, folder: Path, name: str = "page", python: str = sys.executable) -> Iterator[str]:
    """Follow a page in a folder; yield each block of commands after it has run.

    Commands find the programs of the environment of `python` first.

    Raises:
        TutorialError: The page does not do what it says.
    """
    printed = ""
    for block in blocks(page):
        if block.title == PRINTS:
            missing = [line for line in block.text.splitlines() if line.strip() not in printed]
            if missing:
                raise TutorialError(f"{name}: not printed: {missing[0]!r}; the output was:\n{printed[-2000:]}")
        elif block.title:
            (folder / block.title).parent.mkdir(parents=True, exist_ok=True)
            (folder / block.title).write_text(block.text, encoding="utf-8")
        elif block.language == "sh":
            printed = _run(block.text, folder, name, python)
            yield block.text


def _run(commands: str, folder: Path, name: str, python: str) -> str:
    """Return the output of the commands on both streams."""
    environment = {**os.environ, "PATH": f"{Path(python).parent}{os.pathsep}{os.environ['PATH']}"}
    for variable in [key for key in environment if key.startswith("STUCKSOLVER_")]:
        del environment[variable]
    command = ["bash", "-euo", "pipefail", "-c", commands]
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=LIMIT_S, check=False
    )
    if done.returncode != 0:
        raise TutorialError(
            f"{name}: exit code {done.returncode} of\n{commands}\n{done.stdout[-2000:]}{done.stderr[-2000:]}"
        )
    return done.stdout + done.stderr


def checkout(folder: Path) -> None:
    """Copy the files that a newcomer has after cloning, without the large data of results and training."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in listed.split("\0"):
        if CLONED.match(name) and (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)


def main() -> int:
    """Run the pages; return 1 if a page does not do what it says."""
    names = sys.argv[1:] or [page.stem for page in sorted(PAGES.glob("*.md"))]
    bad = 0
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            checkout(Path(folder))
            start = begun = time.monotonic()
            try:
                for commands in follow((PAGES / f"{name}.md").read_text(encoding="utf-8"), Path(folder), name):
                    now = time.monotonic()
                    print(f"{name}: {now - begun:6.1f} s  {commands.splitlines()[0]}", flush=True)
                    begun = now
                print(f"{name}: {time.monotonic() - start:6.1f} s  in total", flush=True)
            except (TutorialError, subprocess.TimeoutExpired) as error:
                # A failed page must not stop the others.
                print(f"error: {error}", file=sys.stderr)
                bad = 1
    return bad


if __name__ == "__main__":
    sys.exit(main())
