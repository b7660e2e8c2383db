"""Measures an exported far detector anew.

```
python -m lab.perception.training.camera.far_calibrate --run OUT --check DIR
```

The network, its threshold and its fit of ranges are unchanged. Recall by range and look, repeated misses and precision
come from the recordings: from another camera or simulator, or from more of them than at the training.

With `--part DIR` it measures only the recall of vehicles that are partly covered by something nearer: DIR holds
recordings of `far_scenes --queued`. Until then, the camera's sight distance ends where a car ahead covers the road.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lab.perception.training.camera.far_data import load
from lab.perception.training.camera.far_evaluate import Run, check, check_part, written, written_part
from stucksolver_perception.camera.far_detector import VERSION
from stucksolver_perception.measurements import Pixels
from stucksolver_perception.network_files import load_session

UNCHANGED = ("threshold", "range")


def calibrate(run: Path, check_on: Sequence[Path], jobs: int = 1) -> dict[str, Any]:
    """Rewrite `far.json` in the folder `run`, print the tables, and return the new card.

    Raises:
        RecordingError: A folder has no recordings.
        ValueError: No image has an instance mask.
        NetworkFileError: The network is missing, damaged or of another version.
    """
    held = load(check_on, jobs)
    outputs, card = _network(run, jobs)
    found = check(outputs, held, float(card["threshold"]))
    new_card: dict[str, Any] = {**card, **{name: item for name, item in found.items() if name not in UNCHANGED}}
    new_card["checked_on"] = sorted({town for town, _ in held.about})
    new_card["checked_pictures"] = len(held)
    print(written(new_card))
    (run / "far.json").write_text(json.dumps(new_card, indent=1) + "\n", encoding="utf-8")
    return new_card


def calibrate_part(run: Path, check_on: Sequence[Path], jobs: int = 1) -> dict[str, Any]:
    """Write the metrics of partly visible vehicles into `far.json` in the folder `run`, and print them.

    It returns the new card and raises the errors of `calibrate`.
    """
    held = load(check_on, jobs)
    outputs, card = _network(run, jobs)
    part = check_part(outputs, held, card)
    new_card = {**card, "part": {**part, "checked_on": sorted({town for town, _ in held.about})}}
    print(written_part(new_card))
    (run / "far.json").write_text(json.dumps(new_card, indent=1) + "\n", encoding="utf-8")
    return new_card


def _network(run: Path, jobs: int) -> tuple[Run, dict[str, Any]]:
    session, card = load_session(run / "far.onnx", run / "far.json", VERSION, jobs)

    def outputs(strip: Pixels) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        peaks, rest = session.run(None, {"strip": strip[None]})
        return peaks[0], rest[0]

    return outputs, card


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--run", type=Path, required=True, help="folder with far.onnx and far.json")
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--check", type=Path, nargs="+", help="held-out recordings")
    what.add_argument("--part", type=Path, nargs="+", help="held-out recordings of `far_scenes --queued`")
    parser.add_argument("--jobs", type=int, default=1, help="number of reading processes, and the network's threads")
    options = parser.parse_args(arguments)
    if options.part:
        calibrate_part(options.run, options.part, options.jobs)
    else:
        calibrate(options.run, options.check, options.jobs)


if __name__ == "__main__":
    main()
