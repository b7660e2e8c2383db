"""Runs the tests as on other machines: `python -m lab.releasing.portable [--times 3] [--only NAME] [TESTS ...]`.

Each setting changes a property that must not matter: the processor's instructions and the libraries' kernels for it
(which round differently), the number of workers, the load, the order of sets, the user's language, time zone and home
folder. A failure under one setting is a test, or a decision of the product, that depends on the machine.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
"""Root of the repository."""
MARKS = "not site and not slow"
BUSY = (sys.executable, "-c", "while True: pass")


@dataclass(frozen=True)
class Setting:
    """One way to run the tests.

    Attributes:
        name: Its name.
        what: The machine that it represents.
        variables: Environment variables.
        workers: Number of pytest's workers.
        busy: Number of parallel busy loops for each core.
        home: True for a new, empty home folder, and files that only their owner may read.
    """

    name: str
    what: str
    variables: dict[str, str] = field(default_factory=dict)
    workers: int = 2
    """Number of pytest's workers."""
    busy: int = 0
    """Number of busy loops for each core."""
    home: bool = False


def settings() -> tuple[Setting, ...]:
    """Return the settings, those that fail most quickly first."""
    old = {
        "NPY_DISABLE_CPU_FEATURES": " ".join(_dispatched()),
        "OPENBLAS_CORETYPE": "Nehalem",
        "NUMBA_CPU_NAME": "generic",
        "NUMBA_CPU_FEATURES": "",
        "PYTHONHASHSEED": "1",
    }
    middle = {"OPENBLAS_CORETYPE": "Sandybridge", "OMP_NUM_THREADS": "1", "PYTHONHASHSEED": "2"}
    abroad = {
        "LC_ALL": "C",
        "PYTHONUTF8": "0",
        "PYTHONCOERCECLOCALE": "0",
        "TZ": "Pacific/Apia",
        "PYTHONHASHSEED": "3",
    }
    return (
        Setting("old", "a processor of 2008: other rounding in numpy, BLAS and compiled loops", old),
        Setting("load", "four workers beside two busy loops for each core", workers=4, busy=2),
        Setting("one", "one worker, another BLAS kernel", middle, workers=1),
        Setting("abroad", "no UTF-8, a time zone beyond the date line, an empty home folder", abroad, home=True),
    )


def _dispatched() -> list[str]:
    """Return the groups of instructions that numpy may use here beyond its minimum."""
    from numpy._core import _multiarray_umath as core  # type: ignore[attr-defined,unused-ignore]

    return [name for name in core.__cpu_dispatch__ if core.__cpu_features__.get(name)]


def run(setting: Setting, pytest_args: list[str]) -> int:
    """Run the tests under one setting; return pytest's exit code."""
    with ExitStack() as ended:
        # A separate cache: code that numba compiled for one processor must not be used for another.
        folder = ended.enter_context(tempfile.TemporaryDirectory(prefix="portable-"))
        variables = {**os.environ, **setting.variables, "NUMBA_CACHE_DIR": f"{folder}/numba"}
        if setting.home:
            home = Path(folder) / "home"
            home.mkdir()
            variables_kept = {name: value for name, value in variables.items() if not name.startswith("XDG_")}
            variables = {**variables_kept, "HOME": str(home)}
        for _ in range(setting.busy * (os.cpu_count() or 1)):
            process = subprocess.Popen(BUSY)
            ended.callback(process.wait)
            ended.callback(process.kill)
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--dist", "loadfile"]
        command += ["--no-loadscope-reorder", "-n", str(setting.workers), "-m", MARKS, *pytest_args]
        umask = 0o077 if setting.home else -1
        return subprocess.run(command, cwd=ROOT, env=variables, check=False, umask=umask).returncode


def main() -> int:
    """Run the tests under every setting; return 1 if any test fails."""
    known = {item.name: item for item in settings()}
    parser = argparse.ArgumentParser(prog="python -m lab.releasing.portable", description=__doc__)
    parser.add_argument("--times", type=int, default=1, help="how often under each setting (default: 1)")
    parser.add_argument("--only", action="append", choices=tuple(known), help="only this setting; may be repeated")
    parser.add_argument("pytest_args", nargs="*", help="for pytest, as folders of tests; all tests if empty")
    options = parser.parse_args()
    failed = []
    for setting in (known[name] for name in options.only or known):
        for number in range(options.times):
            print(f"{setting.name} ({setting.what}), run {number + 1} of {options.times}", flush=True)
            if run(setting, options.pytest_args):
                failed.append(f"{setting.name}, run {number + 1}")
    print("failed: " + "; ".join(failed) if failed else "all tests pass under all settings")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
