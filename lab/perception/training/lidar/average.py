"""Averages two networks, one of which was trained further from the other.

```
python -m lab.perception.training.lidar.average A B --out DIR
```

The mean preserves most of the abilities of both (`lab.training.restore.mean_of`).
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import torch

from lab.perception.training.lidar.export import AVERAGED
from lab.perception.training.lidar.net import restore
from lab.perception.training.lidar.train import CARD as TRAINING
from lab.perception.training.lidar.train import FIGURES, WEIGHTS
from lab.training.restore import RestoreError, mean_of
from stucksolver_perception.lidar.detector import CARD


def average(first: Path, second: Path, share: float, out: Path) -> None:
    """Write `lidar.pt` and `training.json` with the weighted mean of two exported networks to the folder `out`.

    Args:
        first: An exported `lidar.onnx`.
        second: Another one, that was trained further from the first, with its card next to it.
        share: Weight of the second, 0 to 1.
        out: Output folder, for `lab.perception.training.lidar.export`.

    Raises:
        RestoreError: One of the files holds no network, their sizes differ, or the second has no card.
    """
    item, other = restore(first), restore(second)
    if item.widths != other.widths:
        raise RestoreError(f"different widths: {second} has {other.widths}, {first} has {item.widths}")
    card_file = second.with_name(CARD)
    try:
        trained: dict[str, Any] = json.loads(card_file.read_text(encoding="utf-8"))["trained"]
        card = {key: trained[key] for key in FIGURES} | {AVERAGED: share}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise RestoreError(f"no card of a training: {card_file} ({error}). Export the network again") from error
    mean = mean_of(item.state_dict(), other.state_dict(), share)
    out.mkdir(parents=True, exist_ok=True)
    torch.save({"weights": mean, "widths": item.widths}, out / WEIGHTS)
    (out / TRAINING).write_text(json.dumps(card, indent=1) + "\n", encoding="utf-8")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("first", type=Path, help="an exported lidar.onnx")
    parser.add_argument("second", type=Path, help="one that was trained on from the first")
    parser.add_argument("--share", type=float, default=0.5, help="weight of the second, 0 to 1")
    parser.add_argument("--out", type=Path, required=True, help="folder for lidar.pt, to be exported")
    options = parser.parse_args(arguments)
    average(options.first, options.second, options.share, options.out)


if __name__ == "__main__":
    main()
