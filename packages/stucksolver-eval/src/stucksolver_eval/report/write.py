"""Writes the report atomically."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from stucksolver_eval.report.page import page
from stucksolver_eval.report.run_log_packing import pack
from stucksolver_eval.results.run_log import RunLog


class ReportError(RuntimeError):
    """The report could not be written. The message names the file, the cause and the remedy.

    An existing report is unchanged.
    """


def write_report(runs: Sequence[RunLog], path: str | os.PathLike[str], title: str, notes: Sequence[str] = ()) -> None:
    """Write one self-contained HTML file. Missing folders are created, and an older file is replaced at the end.

    Runs of the same scenario and seed are shown side by side, in the given order. `notes` are lines of plain text below
    the title. Raises `ReportError` if the file cannot be written.
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
            f"cannot write report: {target}: {error.strerror or error}. "
            f"It needs {len(text.encode()) / 1e6:.1f} MB: free that much space there or give another path"
        ) from error
    finally:
        _remove(unfinished)


def _write_through(path: Path, text: str) -> None:
    """Write and flush to disk, so that a full disk raises an error here."""
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())


def _remove(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError:
        # The folder itself may be unusable. The original error is more useful than this one.
        return
