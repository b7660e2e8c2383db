"""Starts the training of perception's networks, each in a process of its own, and puts what came out in its place."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from stucksolver_eval.files import cannot_write


class TrainingError(RuntimeError):
    """It cannot be trained or exported; the message says why and what to do."""


@dataclass(frozen=True)
class Network:
    """`module`: trains it. `files`: what the training leaves for use; empty where `exporter` makes them."""

    module: str
    files: tuple[str, ...]
    package: str
    """Holds the folder `data` that ships."""
    exporter: str = ""


NETWORKS = {
    "lidar": Network("stucksolver_train.lidar.train", (), "lidar", "stucksolver_train.lidar.export"),
    "crops": Network("stucksolver_train.camera.crops_train", ("crops.onnx", "crops.json"), "camera"),
    "far": Network("stucksolver_train.camera.far_train", ("far.onnx", "far.json"), "camera"),
}


@dataclass(frozen=True)
class TrainSpec:
    """`data`, `check`: folders of recordings; `out`: gets a folder for each network. Minutes are of learning alone."""

    data: tuple[Path, ...]
    check: tuple[Path, ...]
    out: Path
    only: tuple[str, ...] = ()
    minutes: float = 8.0
    seed: int = 1


def train_networks(spec: TrainSpec) -> None:
    """One after the other; a network that fails ends it. Raises `TrainingError`."""
    require_torch()
    for name in spec.only or NETWORKS:
        told = ["--data", *map(str, spec.data), "--check", *map(str, spec.check), "--out", str(spec.out / name)]
        _run(name, NETWORKS[name].module, [*told, "--minutes", str(spec.minutes), "--seed", str(spec.seed)])


def export_networks(run: Path, check: Sequence[Path], to: Path | None, only: Sequence[str]) -> list[Path]:
    """Put trained networks where perception looks for them, or into `to`; the folders that got them.

    Args:
        run: The `out` of a training.
        check: Recordings held out, with which an exported network is compared.
        to: Instead of the folders that ship.
        only: Networks; without any all that `run` has.

    Raises:
        TrainingError: A network is not there, or is worse after its export.
        OutputError: The folder cannot be written to.
    """
    found = []
    for name in only or [one for one in NETWORKS if (run / one).is_dir()]:
        network = NETWORKS[name]
        target = to or _shipped(network.package)
        if network.exporter:
            require_torch()
            _run(name, network.exporter, ["--run", str(run / name), "--check", *map(str, check), "--out", str(target)])
        else:
            _copy([run / name / file for file in network.files], target)
        found.append(target)
    if not found:
        raise TrainingError(f"{run}: there is no trained network; train some with `stucksolver perception train`")
    return found


def require_torch() -> None:
    """Raises `TrainingError` where torch is not installed."""
    if find_spec("torch") is None:
        raise TrainingError("torch is not installed, which training needs: pip install torch onnx")


def _run(name: str, module: str, arguments: list[str]) -> None:
    code = subprocess.run([sys.executable, "-m", module, *arguments], check=False).returncode
    if code:
        raise TrainingError(f"{name}: {module} ended with exit code {code}; what happened is printed above")


def _shipped(package: str) -> Path:
    import stucksolver.perception

    return Path(stucksolver.perception.__file__).with_name(package) / "data"


def _copy(files: Sequence[Path], target: Path) -> None:
    missing = [file for file in files if not file.is_file()]
    if missing:
        raise TrainingError(f"{missing[0]}: there is no such file; has this network been trained to the end?")
    try:
        target.mkdir(parents=True, exist_ok=True)
        for file in files:
            shutil.copyfile(file, target / file.name)
    except OSError as error:
        raise cannot_write(target, error) from error
