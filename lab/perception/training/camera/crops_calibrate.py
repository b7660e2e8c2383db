"""Calibrates an exported crop network anew.

```
python -m lab.perception.training.camera.crops_calibrate --run OUT --check DIR
```

The network is unchanged. Temperatures and thresholds come from all check recordings; the printed scores of each half
use the thresholds of the other half. This is for recordings of another camera or simulator, or for more of them than at
the training.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lab.perception.training.camera.crops_data import Crops, crops_in
from lab.perception.training.camera.crops_evaluate import Logits, cross_check, report
from stucksolver_perception.camera.crop_network import HEADS

AT_ONCE = 256
"""Number of crops that pass through the network together."""


def calibrate(run: Path, check: Sequence[Path], jobs: int = 1, only: Sequence[str] = ()) -> dict[str, Any]:
    """Rewrite `crops.json` in the folder `run`, print the scores, and return the new card.

    With `only`, names of `HEADS`, the temperatures and thresholds of the others are unchanged.

    Raises:
        RecordingError: A folder has no recordings.
        ValueError: The recordings contain no crops.
    """
    held = crops_in(check, jobs)
    if not len(held):
        raise ValueError("no crops in the recordings. They need images with instance masks")
    card, scores = cross_check(logits_of(run / "crops.onnx", held), held)
    print(report(scores))
    file = run / "crops.json"
    new_card: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    for part, values in card.items():
        new_card[part] |= {head: value for head, value in values.items() if not only or head in only}
    new_card["trained"]["check_crops"] = len(held)
    file.write_text(json.dumps(new_card, indent=1) + "\n", encoding="utf-8")
    return new_card


def logits_of(file: Path, crops: Crops) -> Logits:
    """Return the outputs of an exported network for crops, cut in the same way as at runtime."""
    import onnxruntime

    session = onnxruntime.InferenceSession(str(file), providers=["CPUExecutionProvider"])
    pixels = crops.middles
    parts = [
        session.run(None, {"crops": pixels[i : i + AT_ONCE], "features": crops.features[i : i + AT_ONCE]})
        for i in range(0, len(crops), AT_ONCE)
    ]
    return Logits.from_outputs([np.concatenate(part).astype(np.float64) for part in zip(*parts, strict=True)])


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--run", type=Path, required=True, help="folder with crops.onnx and crops.json")
    parser.add_argument("--check", type=Path, nargs="+", required=True, help="held-out recordings")
    parser.add_argument("--jobs", type=int, default=1, help="number of reading processes")
    parser.add_argument("--only", default="", help=f"heads to calibrate, of {', '.join(HEADS)}; otherwise all")
    options = parser.parse_args(arguments)
    only = [item for item in options.only.split(",") if item]
    if unknown := [item for item in only if item not in HEADS]:
        parser.error(f"--only: expected some of {', '.join(HEADS)}, got {unknown[0]}")
    calibrate(options.run, options.check, options.jobs, only)


if __name__ == "__main__":
    main()
