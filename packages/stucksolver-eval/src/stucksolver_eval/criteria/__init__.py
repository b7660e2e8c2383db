"""The benchmark's criteria for a drive, tick by tick, over the `carla` client API; see `criteria.monitor`.

`criteria.criterion` needs no client, so that scores can be computed without one.
"""

from stucksolver_eval.criteria.criterion import Criterion, EgoTick, Infraction

__all__ = ["Criterion", "EgoTick", "Infraction"]
