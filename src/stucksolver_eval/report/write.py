"""Writes the report, whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from stucksolver_eval.report.pack import pack
from stucksolver_eval.report.page import page
from stucksolver_eval.results.runlog import RunLog


class ReportError(RuntimeError):
    """The report could not be written; the message names the file, the cause and what to do.

    A report that was there before is unharmed.
    """


def write_report(runs: Sequence[RunLog], path: str | os.PathLike[str], title: str, notes: Sequence[str] = ()) -> None:
    """Writes one self-contained HTML file; folders on the way are made, an older file is replaced at the end.

    Runs of the same scenario and seed stand side by side, in the order given. `notes` are lines of plain text
    under the title. Raises ReportError when the file cannot be written.
    """
    target = Path(path)
    text = page(title, pack(runs, title, notes))
    unfinished = target.with_name(f".{target.name}.{os.getpid()}.tmp")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        _write_through(unfinished, text)
        os.replace(unfinished, target)
    except OSError as error:
        raise ReportError(
            f"cannot write the report to {target}: {error.strerror or error}; "
            f"it needs {len(text.encode()) / 1e6:.1f} MB: free that much space there or give another path"
        ) from error
    finally:
        _remove(unfinished)


def _write_through(path: Path, text: str) -> None:
    """Writes to the disk itself, so that a full one is noticed here."""
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())


def _remove(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError:
        # The folder itself may be unusable; the error that led here says more than this one would.
        return
