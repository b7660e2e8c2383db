"""Makes what the product ships of trained weights: an ONNX encoder and a table of word pieces, both in 8 bits.

    python -m training.words.export --weights DIR --data DIR --version 1 --out src/stucksolver/words/data

`--weights`: what `training.words.train` wrote; `--data`: its tokenizer and the sentences kept apart (`dev.npz`), on
which the probabilities are calibrated. Prints how many readings of these the 8-bit network shares with the float one.
"""

from __future__ import annotations

import argparse
import json
import shutil
from pathlib import Path

import numpy as np
import onnx
import torch
from onnx import TensorProto, helper, numpy_helper

from stucksolver.words.fields import INTENT, LOGITS, Doubt, softmax
from stucksolver.words.network import NetworkReader, unpacked
from training.words.model import WIDTH, Reader
from training.words.train import load_parts

MOVE = 0.8
AGAINST = 0.08
STAY = 0.3
"""Least and most probabilities of a reading that counts; docs/words.md says how they were chosen."""
BLOCK = 16
"""So many weights share a scale. One scale a column changed 1.2 % of the readings, this changes 0.5 %."""
BLOCKED_OPSET = 21
"""The first one whose DequantizeLinear knows blocks."""
LEAST_WEIGHTS = 10_000
"""Arrays smaller than this stay floats."""


def main() -> None:
    parser = argparse.ArgumentParser(description="Export the reader of words.")
    parser.add_argument("--weights", type=Path, required=True)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--version", required=True)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    weights = load_parts(options.weights)
    table = weights.pop("words.weight").numpy()
    reader = Reader(LOGITS)
    reader.load_state_dict({name.removeprefix("reader."): value for name, value in weights.items()})
    reader.eval()
    write_pieces(table, options.out / "pieces.npz")
    write_encoder(reader, options.out / "encoder.onnx")
    shutil.copyfile(options.data / "tokenizer.json", options.out / "tokenizer.json")
    card = {"version": options.version, "doubt": vars(Doubt(1.0, MOVE, AGAINST, STAY))}
    (options.out / "card.json").write_text(json.dumps(card, indent=1) + "\n", encoding="utf-8")
    dev = np.load(options.data / "dev.npz")
    ours = shipped(options.out, dev)
    exact = floats(reader, table, dev)
    same = (ours[:, INTENT].argmax(1) == exact[:, INTENT].argmax(1)).mean()
    right = (ours[:, INTENT].argmax(1) == dev["intent"]).mean()
    card["doubt"]["temperature"] = calibrated(ours[:, INTENT], dev["intent"])
    (options.out / "card.json").write_text(json.dumps(card, indent=1) + "\n", encoding="utf-8")
    print(f"{len(dev['intent'])} sentences kept apart: right {right:.4f}, as the float network {same:.4f}, card {card}")


def quantized(array: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """8-bit numbers, and a scale for each `BLOCK` of a row: (rows, columns) int8, (rows, columns / BLOCK) float32."""
    blocks = array.reshape(len(array), -1, BLOCK)
    scale = (np.maximum(np.abs(blocks).max(axis=2), 1e-9) / 127).astype(np.float16).astype(np.float32)
    whole = np.clip(np.round(blocks / scale[..., None]), -127, 127)
    return whole.astype(np.int8).reshape(array.shape), scale


def write_pieces(table: np.ndarray, file: Path) -> None:
    """The vectors of all word pieces: `table` (pieces, width) int8, `scale` (pieces, width / BLOCK) float16."""
    whole, scale = quantized(table)
    np.savez_compressed(file, table=whole, scale=scale.astype(np.float16))


def write_encoder(reader: Reader, file: Path) -> None:
    """The encoder as ONNX, its matrices in 8 bits behind DequantizeLinear, one scale for a block of a column."""
    example = (torch.zeros(1, 9, WIDTH), torch.zeros(1, 9, dtype=torch.int64), torch.ones(1, 9))
    names, axes = ["vectors", "kinds", "mask"], {0: "batch", 1: "tokens"}
    torch.onnx.export(
        reader, example, str(file), input_names=names, output_names=["logits"], opset_version=17, dynamo=False,
        dynamic_axes=dict.fromkeys(names, axes),
    )  # fmt: skip
    model = onnx.load(str(file))
    kept, nodes = [], []
    for array in model.graph.initializer:
        value = numpy_helper.to_array(array)
        if value.ndim != 2 or value.size < LEAST_WEIGHTS or value.dtype != np.float32:
            kept.append(array)
            continue
        columns, scale = quantized(np.ascontiguousarray(value.T))
        name = array.name
        kept += [
            numpy_helper.from_array(np.ascontiguousarray(columns.T), f"{name}.q"),
            numpy_helper.from_array(np.ascontiguousarray(scale.T), f"{name}.scale"),
        ]
        inputs = [f"{name}.q", f"{name}.scale"]
        nodes.append(helper.make_node("DequantizeLinear", inputs, [name], axis=0, block_size=BLOCK))
    del model.graph.initializer[:]
    model.graph.initializer.extend(kept)
    rest = list(model.graph.node)
    del model.graph.node[:]
    model.graph.node.extend([*nodes, *rest])
    model.opset_import[0].version = BLOCKED_OPSET
    onnx.checker.check_model(model)
    assert all(i.data_type != TensorProto.DOUBLE for i in kept)
    onnx.save(model, str(file))


def shipped(folder: Path, dev: dict[str, np.ndarray]) -> np.ndarray:
    """The logits of the network as it is shipped, by the product's own code."""
    _, table, scale, session = NetworkReader(folder)._parts
    out = []
    for ids, kinds, length in zip(dev["ids"], dev["kinds"], dev["length"], strict=True):
        n = int(length)
        vectors = unpacked(table, scale, ids[:n])[None]
        fed = {"vectors": vectors, "kinds": kinds[None, :n].astype(np.int64), "mask": np.ones((1, n), np.float32)}
        out.append(session.run(None, fed)[0][0])
    return np.stack(out)


def floats(reader: Reader, table: np.ndarray, dev: dict[str, np.ndarray]) -> np.ndarray:
    """The logits of the network as it was trained."""
    out = []
    with torch.no_grad():
        for ids, kinds, length in zip(dev["ids"], dev["kinds"], dev["length"], strict=True):
            n = int(length)
            vectors = torch.from_numpy(table[ids[:n].astype(np.int64)])[None]
            out.append(reader(vectors, torch.from_numpy(kinds[None, :n].astype(np.int64)), torch.ones(1, n))[0].numpy())
    return np.stack(out)


def calibrated(logits: np.ndarray, intents: np.ndarray) -> float:
    """The temperature with the least negative log likelihood of the sentences kept apart (Guo et al. 2017)."""
    rows = np.arange(len(intents))
    tried = np.linspace(0.5, 4.0, 71)
    loss = [-np.log(softmax(logits / t)[rows, intents] + 1e-12).mean() for t in tried]
    return round(float(tried[int(np.argmin(loss))]), 2)


if __name__ == "__main__":
    main()
