"""Placement of a scenario type in the shipped suites, with its parameters, as its class declares."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from random import Random

from stucksolver_eval.routes import Parameter
from stucksolver_eval.sites.lane_walk import Town
from stucksolver_eval.sites.movements import JunctionMovement
from stucksolver_eval.sites.parameter_draws import Draw
from stucksolver_eval.sites.site import Site

Finder = Callable[[Town, list[JunctionMovement]], Iterator[Site]]
"""Yields all suitable sites on a map, from the map and the movements through its junctions."""


@dataclass(frozen=True)
class SuitePlacement:
    """Five routes of a suite, with ids from `first_id` on, at sites that `find` yields."""

    suite: str
    first_id: int
    find: Finder
    values: Mapping[str, Draw] = field(default_factory=dict)
    """The scenario's parameters, except those that follow from the site."""
    only_in: str = ""
    """The only suitable map, if others lack blocks for a detour, fast roads, or bicycle lanes."""

    def draw(self, random: Random, free_m: int) -> dict[str, Parameter]:
        """Draw the parameters of one route. The lane is free for `free_m` after the trigger."""
        return {name: value.draw(random, free_m) for name, value in self.values.items()}
