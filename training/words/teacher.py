"""A larger network that the small one learns from: MPNet's twelve encoder layers with the same heads.

It is trained on the same sentences, and never shipped. It takes the small network's word pieces: both checkpoints
share one vocabulary but for the numbers of its pieces. Source of the architecture: Song et al. 2020 (MPNet), with the
relative position buckets of Raffel et al. 2020 (T5); of the start weights: the checkpoint all-mpnet-base-v2
(Apache-2.0).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional as F

WIDTH, HEADS, LAYERS, INNER = 768, 12, 12, 3072
MAX_TOKENS, FIRST_PLACE = 514, 2
"""Places are counted from behind the padding's number."""
BUCKETS, FAR_TOKENS = 32, 128
EPSILON = 1e-5


class Layer(nn.Module):
    """One encoder layer, with the norms after the sums."""

    def __init__(self, dropout: float) -> None:
        super().__init__()
        self.q, self.k, self.v, self.o = (nn.Linear(WIDTH, WIDTH) for _ in range(4))
        self.up, self.down = nn.Linear(WIDTH, INNER), nn.Linear(INNER, WIDTH)
        self.norm_attention, self.norm_out = nn.LayerNorm(WIDTH, eps=EPSILON), nn.LayerNorm(WIDTH, eps=EPSILON)
        self.dropout = nn.Dropout(dropout)

    def forward(self, x: Tensor, bias: Tensor) -> Tensor:
        """`x`: (batch, tokens, width); `bias`: (batch, heads, tokens, tokens)."""
        q, k, v = (one(x).unflatten(-1, (HEADS, WIDTH // HEADS)).transpose(1, 2) for one in (self.q, self.k, self.v))
        mixed = F.scaled_dot_product_attention(q, k, v, attn_mask=bias.to(q.dtype)).transpose(1, 2).flatten(2)
        x = self.norm_attention(x + self.dropout(self.o(mixed)))
        normed: Tensor = self.norm_out(x + self.dropout(self.down(F.gelu(self.up(x)))))
        return normed


class Teacher(nn.Module):
    """Word pieces in, logits of all fields out, as `Reader` gives them.

    `renamed`: (pieces,) its number of each of the small network's pieces.
    """

    renamed: Tensor

    def __init__(self, logits: int, renamed: Tensor, dropout: float = 0.1) -> None:
        super().__init__()
        self.register_buffer("renamed", renamed)
        self.words, self.position = nn.Embedding(int(renamed.max()) + 1, WIDTH), nn.Embedding(MAX_TOKENS, WIDTH)
        self.kind, self.norm = nn.Embedding(2, WIDTH), nn.LayerNorm(WIDTH, eps=EPSILON)
        nn.init.zeros_(self.kind.weight)  # the checkpoint tells no kinds apart
        self.relative = nn.Embedding(BUCKETS, HEADS)
        self.layers = nn.ModuleList(Layer(dropout) for _ in range(LAYERS))
        self.dropout = nn.Dropout(dropout)
        self.hidden, self.fields = nn.Linear(2 * WIDTH, WIDTH), nn.Linear(WIDTH, logits)

    def forward(self, ids: Tensor, kinds: Tensor, mask: Tensor) -> Tensor:
        """(batch, tokens): `ids` of the small network, `kinds` 0 situation, 1 words, `mask` 1.0 where one is."""
        places = torch.arange(ids.shape[1], device=ids.device)
        x = self.words(self.renamed[ids]) + self.position(places + FIRST_PLACE) + self.kind(kinds)
        x = self.dropout(self.norm(x))
        apart = self.relative(buckets(places[None, :] - places[:, None])).permute(2, 0, 1)[None]
        bias = apart + (1.0 - mask)[:, None, None, :] * -1e4
        for layer in self.layers:
            x = layer(x, bias)
        spoken = (mask * kinds)[..., None]
        mean = (x * spoken).sum(1) / spoken.sum(1).clamp(min=1.0)
        logits: Tensor = self.fields(self.dropout(torch.tanh(self.hidden(torch.cat((x[:, 0], mean), -1)))))
        return logits


def buckets(relative: Tensor) -> Tensor:
    """Relative places as numbers of buckets: exact near by, wider further off, the far half of the numbers ahead."""
    half, exact = BUCKETS // 2, BUCKETS // 4
    far = relative.abs().clamp(min=1)
    wide = exact + (torch.log(far / exact) / math.log(FAR_TOKENS / exact) * (half - exact)).long()
    where = torch.where(relative.abs() < exact, relative.abs(), wide.clamp(max=half - 1))
    return where + (relative > 0).long() * half


def load_start(folder: Path) -> tuple[dict[str, Tensor], Tensor]:
    """(weights by their published names, number of each of the small network's pieces) from `teacher-*.npz`, `ids.npy`.

    Matrices are stored in 8 bits, `NAME|q`, with a scale for each row, `NAME|s`.
    """
    found: dict[str, Tensor] = {}
    for file in sorted(folder.glob("teacher-*.npz")):
        with np.load(file) as arrays:
            for name in arrays.files:
                if name.endswith("|q"):
                    scale = arrays[name.removesuffix("q") + "s"].astype(np.float32)
                    found[name.removesuffix("|q")] = torch.from_numpy(arrays[name].astype(np.float32) * scale)
                elif "|" not in name:
                    found[name] = torch.from_numpy(arrays[name])
    return found, torch.from_numpy(np.load(folder / "ids.npy"))


def start_from(teacher: Teacher, weights: Mapping[str, Tensor]) -> None:
    """Take over an MPNet checkpoint of the same size. Raises `KeyError` for one of another make."""
    teacher.words.weight.data.copy_(weights["embeddings.word_embeddings.weight"])
    teacher.position.weight.data.copy_(weights["embeddings.position_embeddings.weight"])
    teacher.relative.weight.data.copy_(weights["encoder.relative_attention_bias.weight"])
    _take(teacher.norm, weights, "embeddings.LayerNorm")
    parts = {
        "q": "attention.attn.q", "k": "attention.attn.k", "v": "attention.attn.v", "o": "attention.attn.o",
        "norm_attention": "attention.LayerNorm", "up": "intermediate.dense", "down": "output.dense",
        "norm_out": "output.LayerNorm",
    }  # fmt: skip
    for i, layer in enumerate(teacher.layers):
        for name, theirs in parts.items():
            _take(getattr(layer, name), weights, f"encoder.layer.{i}.{theirs}")


def _take(module: nn.Module, weights: Mapping[str, Tensor], name: str) -> None:
    for kind in ("weight", "bias"):
        getattr(module, kind).data.copy_(weights[f"{name}.{kind}"])
