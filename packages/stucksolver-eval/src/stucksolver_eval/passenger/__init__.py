"""Passengers on board a drive: what they see of it, and pacing the simulation to real time."""

from stucksolver_eval.passenger.live_view import LiveView, Pictures
from stucksolver_eval.passenger.passenger_page import Aboard, PassengerSpec
from stucksolver_eval.passenger.real_time_pacer import Pace

__all__ = ["Aboard", "LiveView", "Pace", "PassengerSpec", "Pictures"]
