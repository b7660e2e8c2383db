"""Converts trained weights to the shipped files: an ONNX encoder and a table of word pieces, both in 4 bits.

```
python -m lab.language.interpreter.export --weights DIR --data DIR --version 1 --out
    packages/stucksolver-language/src/stucksolver_language/intent/data
```

`--weights`: the interpreter from `lab.language.interpreter.train`; `--data`: its tokenizer and the held-out sentences
(`dev.npz`), on which the probabilities are calibrated. The command prints how many interpretations of these the shipped
network shares with the trained one.
"""

from __future__ import annotations

import argparse
import json
import math
import shutil
from pathlib import Path

import numpy as np
import onnx
import torch
from onnx import TensorProto, helper, numpy_helper
from onnx.external_data_helper import set_external_data

from lab.language.interpreter.model import BLOCK, FIRST_PLACE, WIDTH, Encoder, Linear, Net, packed
from lab.language.interpreter.train import load_parts
from stucksolver_language.intent.intent_decoder import INTENT, LOGITS, ConfidenceThresholds, softmax
from stucksolver_language.intent.network import NetworkInterpreter, unpacked
from stucksolver_language.intent.tokenization import MAX_TOKENS

MOVE = 0.9
"""Least probability of an intent that moves the vehicle; docs/words.md explains the choice."""
AGAINST = 0.08
"""Largest probability of wait, no, cancel and follow together for such an intent; docs/words.md explains the choice."""
STAY = 0.3
"""Least probability of any other intent; docs/words.md explains the choice."""
REROUTE = 0.85
"""Least probability of a new route; docs/words.md explains the choice."""
LEAST_WEIGHTS = 10_000
"""Size below which arrays stay float32 (elements). Ours."""
PART_BYTES = 15_000_000
"""Maximum size of one file (bytes). Ours."""


def main() -> None:
    parser = argparse.ArgumentParser(description="Export the reader of words.")
    parser.add_argument("--weights", type=Path, required=True)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--version", required=True)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    weights = load_parts(options.weights)
    layers = 1 + max(int(name.split(".")[2]) for name in weights if name.startswith("reader.layers."))
    net = Net(len(weights["words.weight"]), LOGITS, layers, coarse=True).eval()
    net.load_state_dict(weights)
    write_pieces(net, options.out / "pieces.npz")
    write_encoder(net.reader, options.out)
    shutil.copyfile(options.data / "tokenizer.json", options.out / "tokenizer.json")
    card = {"version": options.version, "doubt": vars(ConfidenceThresholds(1.0, MOVE, AGAINST, STAY, REROUTE))}
    (options.out / "card.json").write_text(json.dumps(card, indent=1) + "\n", encoding="utf-8")
    dev = np.load(options.data / "dev.npz")
    ours = shipped(options.out, dev)
    exact = floats(net, dev)
    same = (ours[:, INTENT].argmax(1) == exact[:, INTENT].argmax(1)).mean()
    right = (ours[:, INTENT].argmax(1) == dev["intent"]).mean()
    card["doubt"]["temperature"] = calibrated(ours[:, INTENT], dev["intent"])
    (options.out / "card.json").write_text(json.dumps(card, indent=1) + "\n", encoding="utf-8")
    print(f"{len(ours)} sentences kept apart: right {right:.4f}, as the trained network {same:.4f}, card {card}")


def write_pieces(net: Net, file: Path) -> None:
    """Write the vectors of all word pieces.

    They are `table` (pieces, width / 2) uint8 and `scale` (pieces, width / BLOCK) float16.
    """
    table, scale = packed(net.words.weight.detach())
    np.savez_compressed(file, table=table, scale=scale)


def write_encoder(encoder: Encoder, folder: Path) -> None:
    """Write the encoder as ONNX, `encoder.onnx`, and its weights next to it, `encoder-*.bin`.

    Matrices of the layers are in 4 bits (onnxruntime's MatMulNBits), other large arrays in float16.
    """
    for layer in encoder.modules():
        if isinstance(layer, Linear):
            layer.coarse = False  # they were loaded as 4 bits
    encoder.position = torch.nn.Embedding.from_pretrained(encoder.position.weight[: FIRST_PLACE + MAX_TOKENS])
    file = folder / "encoder.onnx"
    example = (torch.zeros(1, 9, WIDTH), torch.zeros(1, 9, dtype=torch.int64), torch.ones(1, 9))
    names, axes = ["vectors", "kinds", "mask"], {0: "batch", 1: "tokens"}
    torch.onnx.export(
        encoder, example, str(file), input_names=names, output_names=["logits"], opset_version=17, dynamo=False,
        dynamic_axes=dict.fromkeys(names, axes),
    )  # fmt: skip
    model = onnx.load(str(file))
    graph = model.graph
    large = {a.name: numpy_helper.to_array(a) for a in graph.initializer if np.prod(a.dims) >= LEAST_WEIGHTS}
    arrays = [a for a in graph.initializer if a.name not in large]
    nodes, coarse = [], set()
    for node in graph.node:
        if node.op_type == "MatMul" and node.input[1] in large:
            coarse.add(node.input[1])
            nodes += _in_4_bits(node, large[node.input[1]], arrays)
        else:
            nodes.append(node)
    casts = []
    for name in large.keys() - coarse:
        arrays.append(numpy_helper.from_array(large[name].astype(np.float16), f"{name}.half"))
        casts.append(helper.make_node("Cast", [f"{name}.half"], [name], to=TensorProto.FLOAT))
    del graph.initializer[:], graph.node[:]
    graph.initializer.extend(arrays)
    graph.node.extend([*casts, *nodes])
    model.opset_import.append(helper.make_opsetid("com.microsoft", 1))
    number = size = 0
    for array in graph.initializer:
        if len(array.raw_data) < LEAST_WEIGHTS:
            continue
        size += len(array.raw_data)
        if size > PART_BYTES:
            number, size = number + 1, len(array.raw_data)
        set_external_data(array, f"encoder-{number}.bin")
    for old in folder.glob("encoder-*.bin"):
        old.unlink()  # onnx appends to an existing file
    onnx.save(model, str(file))


def _in_4_bits(node: onnx.NodeProto, weights: np.ndarray, arrays: list[TensorProto]) -> list[onnx.NodeProto]:
    """Return a product with a matrix (inputs, outputs), and the conversion of its scales to float32."""
    name, (inputs, outputs) = node.input[1], weights.shape
    pairs, scale = packed(torch.from_numpy(np.ascontiguousarray(weights.T)))
    # onnxruntime counts from 0 to 15, with 8 for zero. Ours are in two's complement: the highest bit is flipped.
    blob = (pairs ^ 0x88).reshape(outputs, inputs // BLOCK, BLOCK // 2)
    arrays += [numpy_helper.from_array(blob, f"{name}.q"), numpy_helper.from_array(scale.reshape(-1), f"{name}.half")]
    cast = helper.make_node("Cast", [f"{name}.half"], [f"{name}.scale"], to=TensorProto.FLOAT)
    product = helper.make_node(
        "MatMulNBits", [node.input[0], f"{name}.q", f"{name}.scale"], list(node.output), domain="com.microsoft",
        K=inputs, N=outputs, bits=4, block_size=BLOCK,
    )  # fmt: skip
    return [cast, product]


def shipped(folder: Path, dev: dict[str, np.ndarray]) -> np.ndarray:
    """Return the logits of the shipped network, from the product's own code."""
    _, table, scale, session = NetworkInterpreter(folder)._parts
    out = []
    for ids, kinds, length in zip(dev["ids"], dev["kinds"], dev["length"], strict=True):
        n = int(length)
        vectors = unpacked(table, scale, ids[:n])[None]
        fed = {"vectors": vectors, "kinds": kinds[None, :n].astype(np.int64), "mask": np.ones((1, n), np.float32)}
        out.append(session.run(None, fed)[0][0])
    return np.stack(out)


def floats(net: Net, dev: dict[str, np.ndarray]) -> np.ndarray:
    """Return the logits of the trained network."""
    out = np.empty((len(dev["length"]), LOGITS), np.float32)
    by_length = np.argsort(dev["length"])
    for some in np.array_split(by_length, math.ceil(len(by_length) / 64)):
        longest = int(dev["length"][some].max())
        fed = (torch.from_numpy(dev[name][some, :longest].astype(np.int64)) for name in ("ids", "kinds"))
        mask = torch.from_numpy((np.arange(longest) < dev["length"][some, None]).astype(np.float32))
        with torch.no_grad():
            out[some] = net(*fed, mask).numpy()
    return out


def calibrated(logits: np.ndarray, intents: np.ndarray) -> float:
    """Return the temperature with the least negative log likelihood of the held-out sentences (Guo et al. 2017)."""
    rows = np.arange(len(intents))
    tried = np.linspace(0.5, 4.0, 71)
    loss = [-np.log(softmax(logits / t)[rows, intents] + 1e-12).mean() for t in tried]
    return round(float(tried[int(np.argmin(loss))]), 2)


if __name__ == "__main__":
    main()
