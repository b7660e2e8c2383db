"""The actors of an evaluation run. Their states are read and their commands are sent once per tick."""

from stucksolver_eval.actors.cars import Car, Cars
from stucksolver_eval.actors.path import LanePath
from stucksolver_eval.actors.pool import ActorPool, ActorState, CastError, ScenarioActor

__all__ = ["ActorPool", "ActorState", "Car", "Cars", "CastError", "LanePath", "ScenarioActor"]
