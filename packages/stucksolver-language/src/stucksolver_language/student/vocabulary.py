"""The names that describe plans as numbers, derived from the registry of behaviors."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from stucksolver.plan.behaviors import REGISTRY, Behavior
from stucksolver.scene.base_model import FrozenModel


class Vocabulary(FrozenModel):
    """Names of behaviors and of their parameters. The card of a network contains the one of its training.

    Attributes:
        behaviors: Names of behaviors.
        numbers: Names of parameters that are numbers or booleans.
        choices: `name=value` of each value of a parameter that is a choice.
    """

    behaviors: tuple[str, ...]
    numbers: tuple[str, ...]
    choices: tuple[str, ...]

    @property
    def width(self) -> int:
        """Number of values that describe one behavior."""
        return len(self.behaviors) + 2 * len(self.numbers) + len(self.choices)

    def row(self, behavior: Behavior) -> list[float]:
        """Return one behavior as numbers: its name, each number with a 1 if the behavior sets it, and its choices.

        Raises:
            KeyError: The behavior is not in the vocabulary.
        """
        if behavior.name not in self.behaviors:
            raise KeyError(behavior.name)
        dumped = behavior.model_dump()
        values = [dumped.get(name) for name in self.numbers]
        name = [float(behavior.name == item) for item in self.behaviors]
        numbers = [part for v in values for part in ((0.0, 0.0) if v is None else (_scaled(float(v)), 1.0))]
        choices = [
            float(dumped.get(key) == value) for key, _, value in (choice.partition("=") for choice in self.choices)
        ]
        return [*name, *numbers, *choices]


def _scaled(value: float) -> float:
    """Return a parameter (m, s or m/s, at most 150) scaled to the order of 1."""
    return value / (abs(value) + 10.0) * 2.0


def vocabulary() -> Vocabulary:
    """Return the vocabulary of the current registry."""
    fields = {(name, key): tuple(_parts(schema)) for name, key, schema in _fields()}
    numbers = {k for (_, k), parts in fields.items() if any(p.get("type") in ("number", "boolean") for p in parts)}
    choices = {f"{k}={v}" for (_, k), parts in fields.items() for p in parts for v in p.get("enum", ())}
    return Vocabulary(behaviors=tuple(REGISTRY), numbers=tuple(sorted(numbers)), choices=tuple(sorted(choices)))


def _fields() -> Iterator[tuple[str, str, dict[str, Any]]]:
    for name, kind in REGISTRY.items():
        for key, schema in kind.model_json_schema()["properties"].items():
            if key != "name":
                yield name, key, schema


def _parts(schema: dict[str, Any]) -> Iterator[dict[str, Any]]:
    yield schema
    yield from schema.get("anyOf", ())
