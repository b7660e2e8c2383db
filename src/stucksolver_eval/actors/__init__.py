"""The actors of an evaluation run: spawned and staged, read once a tick, driven, and written once a tick."""

from stucksolver_eval.actors.cars import Car, Cars
from stucksolver_eval.actors.path import LanePath
from stucksolver_eval.actors.pool import ActorPool, ActorState, CastError, ScenarioActor

__all__ = ["ActorPool", "ActorState", "Car", "Cars", "CastError", "LanePath", "ScenarioActor"]
