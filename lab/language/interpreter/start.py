"""The checkpoint from which the training starts, in parts that are small enough to carry to a GPU.

```
python -m lab.language.interpreter.start --checkpoint all-mpnet-base-v2 --data out/words/data --out START
```

`--checkpoint`: a folder with `model.safetensors` and `vocab.txt`; `--data`: the output of
`lab.language.interpreter.encode`. The command writes `start-*.npz` and `ids.npy`, which
`lab.language.interpreter.model.load_start` reads.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
from safetensors.numpy import load_file

PARTS = 3
"""Number of files. Ours."""
LEAST_WEIGHTS = 100_000
"""Size below which matrices stay float32 (elements). Ours."""
SPECIAL = {"[CLS]": "<s>", "[PAD]": "<pad>", "[SEP]": "</s>", "[MASK]": "<mask>"}


def renamed(ours: dict[str, int], theirs: dict[str, int]) -> np.ndarray:
    """Return the checkpoint's number of each of our word pieces, (pieces,).

    A Chinese character that the checkpoint lacks has one of its unused pieces, as in `lab.language.interpreter.encode`,
    so that each one starts from its own vector.
    """
    shift = theirs["[UNK]"] - ours["[UNK]"]  # it has BERT's pieces in BERT's order behind four of its own
    ids = np.arange(max(ours.values()) + 1) + shift
    for name, their_name in SPECIAL.items():
        ids[ours[name]] = theirs[their_name]
    return ids


def main() -> None:
    parser = argparse.ArgumentParser(description="Prepare the start weights of the teacher.")
    parser.add_argument("--checkpoint", type=Path, required=True)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    lines = (options.checkpoint / "vocab.txt").read_text(encoding="utf-8").splitlines()
    theirs = {piece: number for number, piece in enumerate(lines)}
    ours = json.loads((options.data / "tokenizer.json").read_text(encoding="utf-8"))["model"]["vocab"]
    np.save(options.out / "ids.npy", renamed(ours, theirs))
    parts: list[dict[str, np.ndarray]] = [{} for _ in range(PARTS)]
    for name, array in load_file(options.checkpoint / "model.safetensors").items():
        if "pooler" in name or "position_ids" in name:
            continue
        smallest = min(parts, key=lambda part: sum(a.nbytes for a in part.values()))
        if array.ndim == 2 and array.size > LEAST_WEIGHTS:
            scale = np.maximum(np.abs(array).max(1, keepdims=True) / 127, 1e-9)
            smallest[f"{name}|q"] = np.round(array / scale).astype(np.int8)
            smallest[f"{name}|s"] = scale.astype(np.float16)
        else:
            smallest[name] = array.astype(np.float32)
    for number, part in enumerate(parts):
        np.savez(options.out / f"start-{number}.npz", **part)  # type: ignore[arg-type]


if __name__ == "__main__":
    main()
