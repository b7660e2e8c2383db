"""What the benchmark judges a drive by, tick by tick, over the `carla` client API; see `criteria.monitor.Jury`.

`criteria.base` needs no client, so that scores can be computed where there is none.
"""

from stucksolver_eval.criteria.base import Criterion, Infraction, Moment

__all__ = ["Criterion", "Infraction", "Moment"]
