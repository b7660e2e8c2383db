"""Values of the scenarios' parameters, drawn within the ranges of Bench2Drive's own route files."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

from stucksolver_eval.routes import Parameter


@dataclass(frozen=True)
class IntegerDraw:
    """`<name value="..."/>`, a whole number in a range."""

    low: int
    high: int

    def draw(self, random: Random, free_m: int) -> Parameter:
        """Draw a value in the route file's form. `free_m` is the length of free road ahead."""
        return {"value": str(random.randint(self.low, self.high))}


@dataclass(frozen=True)
class RideDistanceDraw(IntegerDraw):
    """Distance that bicycles ride, limited by the free lane."""

    def draw(self, random: Random, free_m: int) -> Parameter:
        """Draw a whole number of meters, limited by the free road."""
        longest_m = max(_SHORTEST_RIDE_M, free_m - _BESIDE_THE_RIDE_M)
        return {"value": str(min(random.randint(self.low, self.high), longest_m))}


@dataclass(frozen=True)
class HundredthsDraw:
    """`<name value="..."/>` with two decimals."""

    low: float
    high: float

    def draw(self, random: Random, free_m: int) -> Parameter:
        """Draw a number with two decimals."""
        return {"value": f"{random.uniform(self.low, self.high):.2f}"}


@dataclass(frozen=True)
class IntervalDraw:
    """`<name from="..." to="..."/>`, each end within its own range."""

    first: tuple[int, int]
    last: tuple[int, int]

    def draw(self, random: Random, free_m: int) -> Parameter:
        """Draw the two ends of an interval."""
        return {"from": str(random.randint(*self.first)), "to": str(random.randint(*self.last))}


@dataclass(frozen=True)
class WordDraw:
    """`<name value="..."/>`, one of several words."""

    words: tuple[str, ...]

    def draw(self, random: Random, free_m: int) -> Parameter:
        """Draw one of the words."""
        return {"value": random.choice(self.words)}


_BESIDE_THE_RIDE_M = 100
"""Length of free lane for the distance to the hazard, the pass, and the end (m). Ours."""
_SHORTEST_RIDE_M = 40
"""Shortest ride of the bicycles (m). Ours."""
Draw = IntegerDraw | HundredthsDraw | IntervalDraw | WordDraw

ON_THE_RIGHT = WordDraw(("right",))
BLOCKERS = WordDraw(
    ("static.prop.container", "static.prop.advertisement", "static.prop.busstoplb", "static.prop.foodcart")
)


def flow_values(speed: tuple[int, int], first: tuple[int, int], last: tuple[int, int]) -> dict[str, Draw]:
    """Return the parameters of a flow of cars: its speed, and the range of its gaps."""
    return {"flow_speed": IntegerDraw(*speed), "source_dist_interval": IntervalDraw(first, last)}
