"""What the benchmark judges a drive by, tick by tick, over the `carla` client API; see `criteria.jury.Jury`.

`criteria.base` needs no client, so that scores can be computed where there is none.
"""

from stucksolver.evaluate.criteria.base import Criterion, Infraction, Moment

__all__ = ["Criterion", "Infraction", "Moment"]
