"""What the benchmark judges a drive by, tick by tick, over the `carla` client API."""

from stucksolver.evaluate.criteria.base import Criterion, Infraction, Moment
from stucksolver.evaluate.criteria.jury import Jury

__all__ = ["Criterion", "Infraction", "Jury", "Moment"]
