"""The network: MPNet's encoder layers, with one small head for each field of an interpretation.

Twelve layers form the teacher, which is trained first and not shipped; the interpreter has some of them, in 4 bits. It
takes the word pieces of BERT's vocabulary, which is MPNet's with other numbers of the pieces. Source of the
architecture: Song et al. 2020 (MPNet), with the relative position buckets of Raffel et al. 2020 (T5). Source of the
start weights: the checkpoint all-mpnet-base-v2 (Apache-2.0).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional as F

WIDTH, HEADS, INNER = 768, 12, 3072
"""Width, number of heads, and inner width of a layer, as in the checkpoint."""
LAYERS = 12
"""Number of layers of the checkpoint."""
MAX_TOKENS, FIRST_PLACE = 514, 2
"""Number of positions, and number of the first one: positions are counted from after the padding's number."""
BUCKETS, FAR_TOKENS = 32, 128
"""Number of buckets of relative positions, and distance from which on all share the last one, as in the checkpoint."""
EPSILON = 1e-5
"""Epsilon of the norms, as in the checkpoint."""
BLOCK = 32
"""Number of neighboring weights that share a scale."""
MOST = 7
"""Largest 4-bit number: they are used from -7 to 7."""


def in_4_bits(weights: Tensor) -> tuple[Tensor, Tensor]:
    """Return the whole numbers, and one scale for each block, of weights (rows, columns).

    The shapes are (rows, blocks, BLOCK) and (rows, blocks, 1).
    """
    blocks = weights.unflatten(-1, (-1, BLOCK))
    scale = (blocks.abs().amax(-1, keepdim=True).clamp(min=1e-6) / MOST).half().float()
    return (blocks / scale).round().clamp(-MOST, MOST), scale


def packed(weights: Tensor) -> tuple[np.ndarray, np.ndarray]:
    """Return the packed numbers (rows, columns / 2) and their scales (rows, blocks).

    A byte holds two numbers, the first one in the low half. Scales are float16.
    """
    whole, scale = in_4_bits(weights.float())
    pairs = whole.flatten(-2).to(torch.int8).numpy().view(np.uint8).reshape(len(weights), -1, 2) & 15
    return pairs[..., 0] | pairs[..., 1] << 4, scale.squeeze(-1).numpy().astype(np.float16)


def spread(pairs: np.ndarray) -> np.ndarray:
    """Return the whole numbers of `packed`, (rows, columns) int8."""
    halves = np.stack((pairs & 15, pairs >> 4), -1).astype(np.int8).reshape(len(pairs), -1)
    return np.where(halves > MOST, halves - 16, halves)


def rounded(weights: Tensor) -> Tensor:
    """Return the same weights rounded to 4 bits. The gradient passes as if they had not been rounded."""
    whole, scale = in_4_bits(weights.float())
    return weights + ((whole * scale).flatten(-2) - weights).detach()


class Linear(nn.Linear):
    """Multiplies by weights rounded to 4 bits if `coarse` is set."""

    coarse = False

    def forward(self, input: Tensor) -> Tensor:
        return F.linear(input, rounded(self.weight) if self.coarse else self.weight, self.bias)


class Layer(nn.Module):
    """One encoder layer, with the norms after the sums."""

    def __init__(self, dropout: float) -> None:
        super().__init__()
        self.q, self.k, self.v, self.o = (Linear(WIDTH, WIDTH) for _ in range(4))
        self.up, self.down = Linear(WIDTH, INNER), Linear(INNER, WIDTH)
        self.norm_attention, self.norm_out = nn.LayerNorm(WIDTH, eps=EPSILON), nn.LayerNorm(WIDTH, eps=EPSILON)
        self.dropout = nn.Dropout(dropout)

    def forward(self, x: Tensor, bias: Tensor) -> Tensor:
        """Return the output; `x`: (batch, tokens, width), `bias`: (batch, heads, tokens, tokens)."""
        q, k, v = (
            linear(x).unflatten(-1, (HEADS, WIDTH // HEADS)).transpose(1, 2) for linear in (self.q, self.k, self.v)
        )
        if torch.jit.is_tracing():
            mixed = (q @ k.transpose(-1, -2) / (WIDTH // HEADS) ** 0.5 + bias).softmax(-1) @ v
        else:
            mixed = F.scaled_dot_product_attention(q, k, v, attn_mask=bias.to(q.dtype))
        x = self.norm_attention(x + self.dropout(self.o(mixed.transpose(1, 2).flatten(2))))
        normed: Tensor = self.norm_out(x + self.dropout(self.down(F.gelu(self.up(x)))))
        return normed


class Encoder(nn.Module):
    """Vectors of word pieces in, logits of all fields out."""

    def __init__(self, logits: int, layers: int, dropout: float = 0.1) -> None:
        super().__init__()
        self.position, self.kind = nn.Embedding(MAX_TOKENS, WIDTH), nn.Embedding(2, WIDTH)
        nn.init.zeros_(self.kind.weight)  # the checkpoint does not distinguish kinds
        self.norm, self.relative = nn.LayerNorm(WIDTH, eps=EPSILON), nn.Embedding(BUCKETS, HEADS)
        self.layers = nn.ModuleList(Layer(dropout) for _ in range(layers))
        self.dropout = nn.Dropout(dropout)
        self.hidden, self.fields = nn.Linear(2 * WIDTH, WIDTH), nn.Linear(WIDTH, logits)

    def forward(self, vectors: Tensor, kinds: Tensor, mask: Tensor) -> Tensor:
        """Return the logits.

        `vectors` (batch, tokens, width); (batch, tokens): `kinds` 0 situation, 1 utterance, `mask` 1.0 for a token.
        """
        places = torch.arange(vectors.shape[1], device=vectors.device)
        x = self.dropout(self.norm(vectors + self.position(places + FIRST_PLACE) + self.kind(kinds)))
        apart = self.relative(buckets(places[None, :] - places[:, None])).permute(2, 0, 1)[None]
        bias = apart + (1.0 - mask)[:, None, None, :] * -1e4
        for layer in self.layers:
            x = layer(x, bias)
        spoken = (mask * kinds)[..., None]
        mean = (x * spoken).sum(1) / spoken.sum(1).clamp(min=1.0)
        logits: Tensor = self.fields(self.dropout(torch.tanh(self.hidden(torch.cat((x[:, 0], mean), -1)))))
        return logits


class Net(nn.Module):
    """Word vectors and encoder together for the training. `coarse`: rounded to 4 bits."""

    def __init__(self, words: int, logits: int, layers: int, *, coarse: bool, dropout: float = 0.1) -> None:
        super().__init__()
        self.words, self.reader, self.coarse = nn.Embedding(words, WIDTH), Encoder(logits, layers, dropout), coarse
        for module in self.reader.modules():
            if isinstance(module, Linear):
                module.coarse = coarse

    def forward(self, ids: Tensor, kinds: Tensor, mask: Tensor) -> Tensor:
        vectors = self.words(ids)
        logits: Tensor = self.reader(rounded(vectors) if self.coarse else vectors, kinds, mask)
        return logits

    @property
    def in_4_bits(self) -> set[str]:
        """Names of the weights that are stored in 4 bits."""
        if not self.coarse:
            return set()
        names = {f"{name}.weight" for name, module in self.named_modules() if isinstance(module, Linear)}
        return names | {"words.weight"}

    @property
    def heads(self) -> list[nn.Parameter]:
        """Parameters that no checkpoint has."""
        return [*self.reader.hidden.parameters(), *self.reader.fields.parameters(), self.reader.kind.weight]


def buckets(relative: Tensor) -> Tensor:
    """Return relative positions as numbers of buckets.

    Near positions have their own bucket, farther ones share wider ones; the second half of the numbers is ahead.
    """
    half, exact = BUCKETS // 2, BUCKETS // 4
    far = relative.abs().clamp(min=1)
    wide = exact + (torch.log(far / exact) / math.log(FAR_TOKENS / exact) * (half - exact)).long()
    where = torch.where(relative.abs() < exact, relative.abs(), wide.clamp(max=half - 1))
    return where + (relative > 0).long() * half


def load_start(folder: Path) -> tuple[dict[str, Tensor], Tensor]:
    """Return weights by their published names, and MPNet's number of each of BERT's pieces.

    They are read from `start-*.npz` and `ids.npy`. Matrices are stored in 8 bits, `NAME|q`, with a scale for each
    row, `NAME|s`.
    """
    found: dict[str, Tensor] = {}
    for file in sorted(folder.glob("start-*.npz")):
        with np.load(file) as arrays:
            for name in arrays.files:
                if name.endswith("|q"):
                    scale = arrays[name.removesuffix("q") + "s"].astype(np.float32)
                    found[name.removesuffix("|q")] = torch.from_numpy(arrays[name].astype(np.float32) * scale)
                elif "|" not in name:
                    found[name] = torch.from_numpy(arrays[name])
    return found, torch.from_numpy(np.load(folder / "ids.npy"))


def start_from(net: Net, weights: Mapping[str, Tensor], renamed: Tensor) -> None:
    """Copy the checkpoint into the network.

    Raises:
        KeyError: The checkpoint has another structure.
    """
    reader = net.reader
    net.words.weight.data.copy_(weights["embeddings.word_embeddings.weight"][renamed])
    reader.position.weight.data.copy_(weights["embeddings.position_embeddings.weight"])
    reader.relative.weight.data.copy_(weights["encoder.relative_attention_bias.weight"])
    _take(reader.norm, weights, "embeddings.LayerNorm")
    parts = {
        "q": "attention.attn.q", "k": "attention.attn.k", "v": "attention.attn.v", "o": "attention.attn.o",
        "norm_attention": "attention.LayerNorm", "up": "intermediate.dense", "down": "output.dense",
        "norm_out": "output.LayerNorm",
    }  # fmt: skip
    for i, layer in enumerate(reader.layers):
        for name, theirs in parts.items():
            _take(getattr(layer, name), weights, f"encoder.layer.{i}.{theirs}")


def _take(module: nn.Module, weights: Mapping[str, Tensor], name: str) -> None:
    for kind in ("weight", "bias"):
        getattr(module, kind).data.copy_(weights[f"{name}.{kind}"])


def take_layers(net: Net, teacher: Net, which: Sequence[int]) -> None:
    """Copy all parts of a larger network, and those of its layers."""
    theirs = teacher.state_dict()
    ours = {name: theirs[name] for name in net.state_dict() if ".layers." not in name}
    for i, k in enumerate(which):
        prefix = f"reader.layers.{k}."
        ours |= {
            name.replace(prefix, f"reader.layers.{i}.", 1): a for name, a in theirs.items() if name.startswith(prefix)
        }
    net.load_state_dict(ours)
