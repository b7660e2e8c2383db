"""Passengers on board a drive: what they see of it, and pacing the simulation to real time."""

from stucksolver_eval.aboard.aboard import Aboard, PassengerSpec
from stucksolver_eval.aboard.pace import Pace
from stucksolver_eval.aboard.view import LiveView, Pictures

__all__ = ["Aboard", "LiveView", "Pace", "PassengerSpec", "Pictures"]
