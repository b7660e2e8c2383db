"""The network: MiniLM's six encoder layers with one small head for each field of a reading.

Parameters are named as in the published BERT checkpoints, so that these load without another library.
Source of the architecture: Devlin et al. 2019 (BERT); of the start weights: Wang et al. 2020 (MiniLM), in the
checkpoint all-MiniLM-L6-v2 (Apache-2.0).
"""

from __future__ import annotations

from collections.abc import Mapping

import torch
from torch import Tensor, nn
from torch.nn import functional as F

WIDTH, HEADS, LAYERS, INNER = 384, 12, 6, 1536
MAX_TOKENS = 512


class Layer(nn.Module):
    """One encoder layer, with the norms after the sums."""

    def __init__(self, dropout: float) -> None:
        super().__init__()
        self.query, self.key, self.value = (nn.Linear(WIDTH, WIDTH) for _ in range(3))
        self.out, self.up, self.down = nn.Linear(WIDTH, WIDTH), nn.Linear(WIDTH, INNER), nn.Linear(INNER, WIDTH)
        self.norm_attention, self.norm_out = nn.LayerNorm(WIDTH, eps=1e-12), nn.LayerNorm(WIDTH, eps=1e-12)
        self.dropout = nn.Dropout(dropout)

    def forward(self, x: Tensor, bias: Tensor) -> Tensor:
        """`x`: (batch, tokens, width); `bias`: (batch, 1, 1, tokens), a large negative number where nothing stands."""
        q, k, v = (self._heads(one(x)) for one in (self.query, self.key, self.value))
        scores = q @ k.transpose(-1, -2) / (WIDTH // HEADS) ** 0.5 + bias
        mixed = (self.dropout(scores.softmax(-1)) @ v).transpose(1, 2).flatten(2)
        x = self.norm_attention(x + self.dropout(self.out(mixed)))
        normed: Tensor = self.norm_out(x + self.dropout(self.down(F.gelu(self.up(x)))))
        return normed

    @staticmethod
    def _heads(x: Tensor) -> Tensor:
        return x.unflatten(-1, (HEADS, WIDTH // HEADS)).transpose(1, 2)


class Reader(nn.Module):
    """Vectors of word pieces in, logits of all fields out."""

    def __init__(self, logits: int, dropout: float = 0.1) -> None:
        super().__init__()
        self.position, self.kind = nn.Embedding(MAX_TOKENS, WIDTH), nn.Embedding(2, WIDTH)
        self.norm = nn.LayerNorm(WIDTH, eps=1e-12)
        self.layers = nn.ModuleList(Layer(dropout) for _ in range(LAYERS))
        self.dropout = nn.Dropout(dropout)
        self.hidden = nn.Linear(2 * WIDTH, WIDTH)
        self.fields = nn.Linear(WIDTH, logits)

    def forward(self, vectors: Tensor, kinds: Tensor, mask: Tensor) -> Tensor:
        """`vectors` (batch, tokens, width); (batch, tokens): `kinds` 0 situation, 1 words, `mask` 1.0 where one is."""
        places = torch.arange(vectors.shape[1], device=vectors.device)
        x = self.norm(vectors + self.position(places) + self.kind(kinds))
        x = self.dropout(x)
        bias = (1.0 - mask)[:, None, None, :] * -1e4
        for layer in self.layers:
            x = layer(x, bias)
        spoken = (mask * kinds)[..., None]
        mean = (x * spoken).sum(1) / spoken.sum(1).clamp(min=1.0)
        logits: Tensor = self.fields(self.dropout(torch.tanh(self.hidden(torch.cat((x[:, 0], mean), -1)))))
        return logits


def start_from(reader: Reader, words: nn.Embedding, weights: Mapping[str, Tensor]) -> None:
    """Take over a BERT checkpoint of the same size. Raises `KeyError` for one of another make."""
    words.weight.data.copy_(weights["embeddings.word_embeddings.weight"])
    reader.position.weight.data.copy_(weights["embeddings.position_embeddings.weight"])
    reader.kind.weight.data.copy_(weights["embeddings.token_type_embeddings.weight"])
    _take(reader.norm, weights, "embeddings.LayerNorm")
    parts = {
        "query": "attention.self.query", "key": "attention.self.key", "value": "attention.self.value",
        "out": "attention.output.dense", "norm_attention": "attention.output.LayerNorm",
        "up": "intermediate.dense", "down": "output.dense", "norm_out": "output.LayerNorm",
    }  # fmt: skip
    for i, layer in enumerate(reader.layers):
        for name, theirs in parts.items():
            _take(getattr(layer, name), weights, f"encoder.layer.{i}.{theirs}")


def _take(module: nn.Module, weights: Mapping[str, Tensor], name: str) -> None:
    for kind in ("weight", "bias"):
        getattr(module, kind).data.copy_(weights[f"{name}.{kind}"])
