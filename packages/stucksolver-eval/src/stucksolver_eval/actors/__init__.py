"""The actors of an evaluation run. Their states are read and their commands are sent once per tick."""

from stucksolver_eval.actors.actor_pool import ActorPool, ActorState, CastError, ScenarioActor
from stucksolver_eval.actors.cars import Car, SimulatedCars
from stucksolver_eval.actors.lane_path import LanePath

__all__ = ["ActorPool", "ActorState", "Car", "CastError", "LanePath", "ScenarioActor", "SimulatedCars"]
