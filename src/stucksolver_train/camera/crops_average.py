"""Averages two crop networks, one trained on from the other, and calibrates the mean.

`python -m stucksolver_train.camera.crops_average OLD NEW --share 0.85 --check DIR --out OUT`

The mean keeps most of what both know (`stucksolver_train.restore.mean_of`). Writes `crops.onnx` and `crops.json` to
OUT.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from stucksolver_train.camera.crops_check import by_halves, report
from stucksolver_train.camera.crops_data import crops_in
from stucksolver_train.camera.crops_export import export
from stucksolver_train.camera.crops_net import restored
from stucksolver_train.camera.crops_train import logits_of
from stucksolver_train.restore import mean_of

AVERAGED = "share_of_the_newer"
"""Entry of the card's training: the weight of the network that was trained on."""


def average(first: Path, second: Path, share: float, check: Sequence[Path], out: Path, jobs: int = 1) -> dict[str, Any]:
    """Writes the weighted mean of two exported networks, calibrated on check recordings. Returns the card.

    Args:
        first: An exported `crops.onnx`.
        second: Another one, that was trained on from the first, with its card beside it.
        share: Weight of the second, 0 to 1.
        check: Folders of held-out recordings.
        out: Output folder.
        jobs: Number of reading processes.

    Raises:
        RestoreError: One of the files holds no crop network.
        RecordingError: A folder has no recordings.
        ValueError: The recordings contain no crops.
    """
    net = restored(first)
    net.load_state_dict(mean_of(net.state_dict(), restored(second).state_dict(), share))
    net.eval()
    held = crops_in(check, jobs)
    if not len(held):
        raise ValueError("the recordings contain no crops: they need images with instance masks")
    card, told = by_halves(logits_of(net, held), held)
    print(report(told))
    trained = json.loads(second.with_suffix(".json").read_text(encoding="utf-8"))["trained"]
    card["trained"] = trained | {AVERAGED: share, "check_crops": len(held)}
    out.mkdir(parents=True, exist_ok=True)
    return export(net, out, card, held)


def main(arguments: Sequence[str] | None = None) -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description="average two crop networks")
    parser.add_argument("first", type=Path, help="an exported crops.onnx")
    parser.add_argument("second", type=Path, help="one that was trained on from the first")
    parser.add_argument("--share", type=float, default=0.5, help="weight of the second, 0 to 1")
    parser.add_argument("--check", type=Path, nargs="+", required=True, help="folders of held-out recordings")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="number of reading processes")
    given = parser.parse_args(arguments)
    average(given.first, given.second, given.share, given.check, given.out, given.jobs)


if __name__ == "__main__":
    main()
