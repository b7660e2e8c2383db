"""The kinds of rung, one file each."""

from stucksolver.ladder.rungs.base import Rung
from stucksolver.ladder.rungs.registry import KINDS, AnyRung

__all__ = ["KINDS", "AnyRung", "Rung"]
