"""Where the shipped suites put a scenario type, and with which parameters: what its class states."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from random import Random

from stucksolver_eval.routes import Parameter
from stucksolver_eval.sites.movements import Movement
from stucksolver_eval.sites.site import Site
from stucksolver_eval.sites.values import Draw
from stucksolver_eval.sites.walk import Town

Finder = Callable[[Town, list[Movement]], Iterator[Site]]
"""All places of a map that fit; the ways through its junctions come with it."""


@dataclass(frozen=True)
class Placed:
    """Five routes of a suite: with ids from `first_id` on, at places that `find` finds."""

    suite: str
    first_id: int
    find: Finder
    values: Mapping[str, Draw] = field(default_factory=dict)
    """The scenario's parameters, but for those that follow from the place."""
    only_in: str = ""
    """The one map that will do: one with blocks to drive round, with fast roads, with lanes for bicycles."""

    def draw(self, random: Random, free_m: int) -> dict[str, Parameter]:
        """The parameters of one route; the lane is free for `free_m` after the trigger."""
        return {name: one.draw(random, free_m) for name, one in self.values.items()}
