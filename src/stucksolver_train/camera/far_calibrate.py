"""Measures an exported far detector anew: `python -m stucksolver_train.camera.far_calibrate --run OUT --check DIR`.

The network, its threshold and its fit of ranges stay as they are. Recall by range and look, repeated misses and
precision come from the recordings: from another camera or simulator, or more of them than there were at the training.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stucksolver.perception.camera.far import VERSION
from stucksolver.perception.camera.weights import load_session
from stucksolver.perception.measurements import Pixels
from stucksolver_train.camera.far_check import check, written
from stucksolver_train.camera.far_data import load

KEPT = ("threshold", "range")


def calibrate(run: Path, check_on: Sequence[Path], jobs: int = 1) -> dict[str, Any]:
    """Rewrites `far.json` in the folder `run`, and prints the tables. Returns the new card.

    Raises:
        RecordingError: A folder has no recordings.
        ValueError: No image has an instance mask.
        WeightsError: The network is missing, damaged or of another version.
    """
    held = load(check_on, jobs)
    session, card = load_session(run / "far.onnx", run / "far.json", VERSION, jobs)

    def outputs(strip: Pixels) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        peaks, rest = session.run(None, {"strip": strip[None]})
        return peaks[0], rest[0]

    found = check(outputs, held, float(card["threshold"]))
    told: dict[str, Any] = {**card, **{name: one for name, one in found.items() if name not in KEPT}}
    told["checked_on"] = sorted({town for town, _ in held.about})
    told["checked_pictures"] = len(held)
    print(written(told))
    (run / "far.json").write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    return told


def main(arguments: Sequence[str] | None = None) -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--run", type=Path, required=True, help="folder with far.onnx and far.json")
    parser.add_argument("--check", type=Path, nargs="+", required=True, help="held-out recordings")
    parser.add_argument("--jobs", type=int, default=1, help="number of reading processes, and the network's threads")
    given = parser.parse_args(arguments)
    calibrate(given.run, given.check, given.jobs)


if __name__ == "__main__":
    main()
