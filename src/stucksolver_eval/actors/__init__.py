"""The actors of an evaluation run: spawned and staged, read once a tick, driven, and written once a tick."""

from stucksolver_eval.actors.cars import Car, Cars
from stucksolver_eval.actors.cast import Cast, CastError, Member, State
from stucksolver_eval.actors.path import LanePath

__all__ = ["Car", "Cars", "Cast", "CastError", "LanePath", "Member", "State"]
