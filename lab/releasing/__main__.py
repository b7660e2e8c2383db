"""Checks a release from a user's point of view: `python -m lab.releasing [--python 3.11 ...] [--out DIR]`.

It builds wheels and sdists of all distributions, and installs them into clean environments for each Python version that
CARLA's client supports. A Python version that is not on this machine is reported as skipped.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from collections.abc import Iterator
from pathlib import Path

from lab.releasing.distributions import PROJECTS, ROOT, file_name

PYTHONS = ("3.10", "3.11", "3.12")
WHEEL_MAX_MB = 60.0
"""Size limit of a wheel (MB). Ours; PyPI's limit is 100 MB, and the weights of words and perception take 50 MB."""
STEP_LIMIT_S = 900.0
"""Time limit of one command (s). Ours."""
CORE = """
import sys
import stucksolver
from stucksolver import StuckSolver
from stucksolver.reasoners import SearchReasoner
absent = {"carla", "carlette", "onnxruntime", "PIL", "scipy"} & set(sys.modules)
assert SearchReasoner().name == "search" and not absent, absent
try:
    import carla
except ImportError:
    print("the core imports, without a simulator")
else:
    sys.exit("the core brought carla along")
"""
SERVES = """
import subprocess, sys
from importlib.metadata import version
import carla
command = [sys.executable, "-m", "carlette", "--port", "0", "--exit-on-stdin-eof", "--client-version", version("carla")]
server = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
port = int(server.stdout.readline().split("listening on ")[1].split()[0].rpartition(":")[2])
client = carla.Client("127.0.0.1", port)
client.set_timeout(60.0)
print("carlette alone serves a client:", client.get_world().get_map().name)
server.stdin.close()
server.wait(20)
"""


NEEDS = {
    "stucksolver-carla": ("stucksolver",),
    "stucksolver-perception": ("stucksolver", "stucksolver-carla"),
    "stucksolver-language": ("stucksolver",),
    "stucksolver-passenger": ("stucksolver", "stucksolver-language"),
}
"""Our distributions that each plug-in requires. They are given as wheels, because no index has them."""
IMPORTS = {name: name.replace("-", "_") for name in NEEDS}


class ReleaseError(RuntimeError):
    """The distributions must not be released."""


def main() -> int:
    """Run the checks; return 1 if one fails, and 2 if no Python version could be checked."""
    parser = argparse.ArgumentParser(prog="python -m lab.releasing", description=__doc__)
    parser.add_argument("--python", action="append", choices=PYTHONS, help="only this version (default: all three)")
    parser.add_argument("--out", type=Path, default=Path("out/release"), help="folder for the output")
    options = parser.parse_args()
    out = options.out.resolve()
    try:
        files = build(out / "dist")
        checked = [name for name in options.python or PYTHONS if _check_python(name, files, out / "environments")]
    except ReleaseError as error:
        # The failed check is printed as one line.
        print(f"error: {error}", file=sys.stderr)
        return 1
    if not checked:
        print(
            f"error: not on this machine: Python {', '.join(options.python or PYTHONS)}. Install one of them",
            file=sys.stderr,
        )
        return 2
    print(f"checked on Python {', '.join(checked)}; wheels and sdists are in {options.out / 'dist'}")
    return 0


def build(dist: Path) -> dict[str, Path]:
    """Build the wheel of each distribution from its sdist, as an installer does.

    Raises:
        ReleaseError: A build fails, or the versions differ.
    """
    shutil.rmtree(dist, ignore_errors=True)
    wheels = {}
    # Determine the version once for all, because a commit may be made in between.
    version = _run([sys.executable, "-m", "hatchling", "version"], cwd=PROJECTS["stucksolver"]).strip()
    for name, project in PROJECTS.items():
        _run([sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", str(dist)], project, version)
        (sdist,) = dist.glob(f"{file_name(name)}-*.tar.gz")
        with tarfile.open(sdist) as packed:
            packed.extractall(dist / "unpacked", filter="data")
        source = dist / "unpacked" / sdist.name.removesuffix(".tar.gz")
        _run([sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(dist)], cwd=source)
        (wheel,) = dist.glob(f"{file_name(name)}-*.whl")
        _check_files(name, wheel, project)
        wheels[name] = wheel
    shutil.rmtree(dist / "unpacked")
    versions = {wheel.name.split("-")[1] for wheel in wheels.values()}
    if len(versions) != 1:
        raise ReleaseError(f"the distributions have different versions: {', '.join(sorted(versions))}")
    return wheels


def _check_files(name: str, wheel: Path, project: Path) -> None:
    """Check a wheel's size, and that it has a license and every file that git tracks below `src`."""
    size_mb = wheel.stat().st_size / 1e6
    print(f"{wheel.name}: {size_mb:.1f} MB")
    if size_mb > WHEEL_MAX_MB:
        raise ReleaseError(f"wheel too large: {wheel.name} has {size_mb:.0f} MB, the limit is {WHEEL_MAX_MB:.0f}")
    listed = subprocess.run(["git", "ls-files", "src"], cwd=project, capture_output=True, text=True, check=True).stdout
    with zipfile.ZipFile(wheel) as packed:
        inside = set(packed.namelist())
    here = [path for path in listed.splitlines() if (project / path).is_file()]
    missing = [path for path in here if path.removeprefix("src/") not in inside]
    if missing:
        raise ReleaseError(f"{len(missing)} files are missing in the wheel: {wheel.name}, for example {missing[0]}")
    if not any("LICENSE" in text for text in inside):
        raise ReleaseError(f"no license in the wheel: {name}")


def _check_python(version: str, wheels: dict[str, Path], folder: Path) -> bool:
    """Check all environments of one Python version; return False if it is not on this machine.

    Raises:
        ReleaseError: A check fails.
    """
    python = find_python(version)
    if python is None:
        print(f"SKIPPED: Python {version} is not on this machine", file=sys.stderr, flush=True)
        return False
    print(f"== Python {version}: {python}", flush=True)
    core = _environment(python, folder / f"{version}-core", [str(wheels["stucksolver"])])
    _print_output([core, "-c", CORE], folder)
    _print_output([core, "-m", "stucksolver", "--version"], folder)
    alone = _environment(python, folder / f"{version}-carlette", [str(wheels["carlette"])])
    _print_output([alone, "-c", SERVES], folder)
    for name, package in IMPORTS.items():
        needed = [str(wheels[other]) for other in NEEDS[name]]
        single = _environment(python, folder / f"{version}-{name}", [str(wheels[name]), *needed])
        _print_output([single, "-c", f"import {package}; print('{name} imports')"], folder)
        _print_output([single, "-m", "stucksolver", "plugins"], folder)
    whole = _environment(python, folder / f"{version}-all", [str(wheel) for wheel in wheels.values()])
    _print_output([whole, "-m", "stucksolver", "demo", "--out", str(folder / f"{version}-demo")], folder)
    if not (folder / f"{version}-demo" / "report.html").is_file():
        raise ReleaseError(f"Python {version}: the demonstration wrote no report")
    _print_output([whole, str(ROOT / "lab" / "releasing" / "licenses.py")], folder)
    return True


def find_python(version: str) -> str | None:
    """Return an interpreter of this version, from PATH or pyenv."""
    for candidate in _candidates(version):
        command = [candidate, "-c", "import sys, venv; print('%d.%d' % sys.version_info[:2])"]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
        except OSError:
            # The candidate does not exist or does not run; the next one is tried.
            continue
        if done.stdout.strip() == version:
            return candidate
    return None


def _candidates(version: str) -> Iterator[str]:
    found = shutil.which(f"python{version}")
    if found:
        yield found
    root = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv")
    yield from (str(path) for path in sorted(root.glob(f"versions/{version}.*/bin/python")))


def _environment(python: str, folder: Path, wanted: list[str]) -> str:
    """Create an environment with these packages and their dependencies; return its interpreter."""
    shutil.rmtree(folder, ignore_errors=True)
    _run([python, "-m", "venv", str(folder)], cwd=ROOT)
    inside = str(folder / "bin" / "python")
    _run([inside, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *wanted], cwd=folder)
    return inside


def _print_output(command: list[str], cwd: Path) -> None:
    for line in _run(command, cwd).splitlines():
        print(f"   {line}", flush=True)


def _run(command: list[str], cwd: Path, version: str = "") -> str:
    """Return the output of a command, isolated from this checkout and its settings.

    Raises:
        ReleaseError: The command fails.
    """
    variables = {
        key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "STUCKSOLVER_", "VIRTUAL_ENV"))
    }
    variables |= {"SETUPTOOLS_SCM_PRETEND_VERSION": version} if version else {}
    done = subprocess.run(
        command, cwd=cwd, env=variables, capture_output=True, text=True, timeout=STEP_LIMIT_S, check=False
    )
    if done.returncode:
        raise ReleaseError(
            f"exit code {done.returncode} of {' '.join(command)[:200]}\n{done.stdout[-1500:]}{done.stderr[-1500:]}"
        )
    return done.stdout


if __name__ == "__main__":
    sys.exit(main())
