"""The actors of an evaluation run: spawned and staged, read once a tick, driven, and written once a tick."""

from stucksolver.evaluate.actors.cars import Car, Cars
from stucksolver.evaluate.actors.cast import Cast, CastError, Member, State
from stucksolver.evaluate.actors.path import LanePath

__all__ = ["Car", "Cars", "Cast", "CastError", "LanePath", "Member", "State"]
