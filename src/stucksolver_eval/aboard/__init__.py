"""People on board of a drive: what they see of it, and how it keeps to their time."""

from stucksolver_eval.aboard.aboard import Aboard, PassengerSpec
from stucksolver_eval.aboard.pace import Pace
from stucksolver_eval.aboard.view import LiveView, Pictures

__all__ = ["Aboard", "LiveView", "Pace", "PassengerSpec", "Pictures"]
