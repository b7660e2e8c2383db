"""Trains perception's networks, each in a separate process, and installs the results."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from stucksolver.atomic_files import cannot_write


class TrainingError(RuntimeError):
    """A network cannot be trained or exported; the message has the reason and the remedy."""


@dataclass(frozen=True)
class NetworkTraining:
    """The training of a network.

    Attributes:
        module: The module that trains it.
        files: The files of the training to install; empty if `exporter` creates them.
        package: The package of `stucksolver_perception` with the shipped folder `data`.
        exporter: The module that exports it, if any.
    """

    module: str
    files: tuple[str, ...]
    package: str
    exporter: str = ""


NETWORKS = {
    "lidar": NetworkTraining(
        "lab.perception.training.lidar.train", (), "lidar", "lab.perception.training.lidar.export"
    ),
    "crops": NetworkTraining("lab.perception.training.camera.crops_train", ("crops.onnx", "crops.json"), "camera"),
    "far": NetworkTraining("lab.perception.training.camera.far_train", ("far.onnx", "far.json"), "camera"),
}


@dataclass(frozen=True)
class TrainSpec:
    """The networks to train.

    Attributes:
        data: Folders of recordings for training.
        check: Folders of recordings for validation.
        out: Output folder; each network gets a folder in it.
        only: Names of networks; all if empty.
        minutes: Training time of each network, without loading and validation.
        seed: Seed of the training.
    """

    data: tuple[Path, ...]
    check: tuple[Path, ...]
    out: Path
    only: tuple[str, ...] = ()
    minutes: float = 8.0
    """Training time of each network (min). Ours."""
    seed: int = 1
    """Seed of the training."""


def train_networks(spec: TrainSpec) -> None:
    """Train the networks one after another.

    Raises:
        TrainingError: A network cannot be trained; the others are not trained.
    """
    require_torch()
    for name in spec.only or NETWORKS:
        arguments = ["--data", *map(str, spec.data), "--check", *map(str, spec.check), "--out", str(spec.out / name)]
        _run(name, NETWORKS[name].module, [*arguments, "--minutes", str(spec.minutes), "--seed", str(spec.seed)])


def export_networks(run: Path, check: Sequence[Path], to: Path | None, only: Sequence[str]) -> list[Path]:
    """Install trained networks in the folders that perception reads, or in `to`; return the folder of each network.

    Args:
        run: The `out` of a training.
        check: Validation recordings, on which an exported network is compared with the original.
        to: Folder to use instead of the shipped ones.
        only: Names of networks; all in `run` if empty.

    Raises:
        TrainingError: A network is missing, or worse after its export.
        OutputError: The folder cannot be written to.
    """
    found = []
    for name in only or [text for text in NETWORKS if (run / text).is_dir()]:
        network = NETWORKS[name]
        target = to or _shipped(network.package)
        if network.exporter:
            require_torch()
            _run(name, network.exporter, ["--run", str(run / name), "--check", *map(str, check), "--out", str(target)])
        else:
            _copy([run / name / file for file in network.files], target)
        found.append(target)
    if not found:
        raise TrainingError(f"no trained network: {run}. Train some with `python -m lab perception train`")
    return found


def require_torch() -> None:
    """Raise `TrainingError` if torch is not installed."""
    if find_spec("torch") is None:
        raise TrainingError("not installed: torch. Install it with `pip install torch onnx`")


def _run(name: str, module: str, arguments: list[str]) -> None:
    code = subprocess.run([sys.executable, "-m", module, *arguments], check=False).returncode
    if code:
        raise TrainingError(f"{name}: exit code {code} of {module}. See its output above")


def _shipped(package: str) -> Path:
    import stucksolver_perception

    return Path(stucksolver_perception.__file__).parent / package / "data"


def _copy(files: Sequence[Path], target: Path) -> None:
    missing = [file for file in files if not file.is_file()]
    if missing:
        raise TrainingError(f"file not found: {missing[0]}. Complete the training of this network")
    try:
        target.mkdir(parents=True, exist_ok=True)
        for file in files:
            shutil.copyfile(file, target / file.name)
    except OSError as error:
        raise cannot_write(target, error) from error
