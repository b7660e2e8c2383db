"""The student's network: an attention encoder over the rows of a scene, and heads for the chain and for plans."""

from __future__ import annotations

from collections.abc import Mapping

import torch
from torch import Tensor, nn

from stucksolver_language.student.feature_encoding import MOST, WIDTHS
from stucksolver_language.student.heads import CAUSES, HOLDS, INTENTS, TIMES_S

KINDS = ("ego", *MOST)
"""Kinds of rows in the order of the mask."""


class Layer(nn.Module):
    """One layer of attention among rows, with pre-normalization."""

    def __init__(self, width: int, heads: int, dropout: float) -> None:
        super().__init__()
        self.heads = heads
        self.before, self.between = nn.LayerNorm(width), nn.LayerNorm(width)
        self.query, self.keys = nn.Linear(width, width), nn.Linear(width, 2 * width)
        self.out = nn.Linear(width, width)
        self.after = nn.Sequential(
            nn.Linear(width, 2 * width), nn.GELU(), nn.Dropout(dropout), nn.Linear(2 * width, width)
        )
        self.dropout = nn.Dropout(dropout)

    def forward(self, rows: Tensor, others: Tensor, mask: Tensor) -> Tensor:
        """Return the rows (batch, n, width) after attention to `others` (batch, m, width) where `mask` (batch, m)."""
        batch, n, width = rows.shape
        query = self.query(self.before(rows)).reshape(batch, n, self.heads, -1).transpose(1, 2)
        both = self.keys(self.before(others)).reshape(batch, -1, 2, self.heads, width // self.heads)
        key, value = both[:, :, 0].transpose(1, 2), both[:, :, 1].transpose(1, 2)
        weights = (query @ key.transpose(2, 3)) * (width // self.heads) ** -0.5
        weights = weights.masked_fill(~mask[:, None, None, :], -1e4).softmax(dim=-1)
        looked = (weights @ value).transpose(1, 2).reshape(batch, n, width)
        rows = rows + self.dropout(self.out(looked))
        return rows + self.dropout(self.after(self.between(rows)))


class StudentNet(nn.Module):
    """Rows of a scene and of plans in, logits out. See `stucksolver_language.student.heads.Numbers`.

    Args:
        plan_width: Width of one behavior of a plan.
        width: Width of a row inside the network.
        layers: Number of layers of the encoder.
        heads: Number of heads of each layer.
        dropout: Share of values dropped in training.
    """

    def __init__(
        self, plan_width: int, width: int = 64, layers: int = 3, heads: int = 4, dropout: float = 0.15
    ) -> None:
        super().__init__()
        self.into = nn.ModuleDict({kind: nn.Linear(WIDTHS[kind], width) for kind in KINDS})
        self.kinds = nn.Parameter(torch.randn(len(KINDS), width) * 0.02)
        self.layers = nn.ModuleList([Layer(width, heads, dropout) for _ in range(layers)])
        self.norm = nn.LayerNorm(width)
        self.hazard, self.cause = nn.Linear(width, len(TIMES_S)), nn.Linear(width, len(CAUSES))
        self.hold, self.intent = nn.Linear(width, len(HOLDS)), nn.Linear(width, len(INTENTS))
        self.behavior = nn.Sequential(nn.Linear(plan_width + width, width), nn.GELU(), nn.Linear(width, width))
        self.slots = nn.Parameter(torch.randn(8, width) * 0.02)
        self.look = Layer(width, heads, dropout)
        self.judged = nn.Sequential(nn.LayerNorm(width), nn.Linear(width, width), nn.GELU(), nn.Linear(width, 3))

    def forward(self, rows: Mapping[str, Tensor], mask: Tensor, plans: Tensor, named: Tensor) -> tuple[Tensor, ...]:
        """Return the outputs in the order of `heads.OUTPUTS`, each with a leading batch axis.

        Args:
            rows: By kind (batch, rows, width of that kind).
            mask: True for rows that are used (batch, all rows).
            plans: (batch, plans, SLOTS, width of a behavior); the last number is 1 for a behavior.
            named: Rows of the objects that the behaviors name (batch, plans, SLOTS).
        """
        parts = [self.into[kind](rows[kind]) + self.kinds[number] for number, kind in enumerate(KINDS)]
        encoded = torch.cat(parts, dim=1)
        for layer in self.layers:
            encoded = layer(encoded, encoded, mask)
        encoded = self.norm(encoded)
        whole, objects = encoded[:, 0], encoded[:, 1 : 1 + MOST["objects"]]
        judged = self._judged(encoded, objects, mask, plans, named)
        return (
            self.hazard(whole),
            self.cause(whole),
            self.hold(whole),
            self.intent(objects),
            judged[..., 0],
            judged[..., 1],
            judged[..., 2],
        )

    def _judged(self, encoded: Tensor, objects: Tensor, mask: Tensor, plans: Tensor, named: Tensor) -> Tensor:
        batch, count, slots, _ = plans.shape
        width = objects.shape[-1]
        none = torch.zeros_like(objects[:, :1])
        rows = torch.cat([objects, none], dim=1)
        places = named.reshape(batch, count * slots, 1).expand(-1, -1, width)
        things = rows.gather(1, places).reshape(batch, count, slots, width)
        each = self.behavior(torch.cat([plans, things], dim=-1)) + self.slots[:slots]
        whole = (each * plans[..., -1:]).sum(dim=2) + encoded[:, :1]
        return torch.as_tensor(self.judged(self.look(whole, encoded, mask)))
