"""Passengers during a run: their view of it, and pacing of the simulation to real time."""

from stucksolver_eval.passenger.live_view import LiveView, Pictures
from stucksolver_eval.passenger.passenger_page import PassengerPage, PassengerSpec
from stucksolver_eval.passenger.real_time_pacer import RealTimePacer

__all__ = ["LiveView", "PassengerPage", "PassengerSpec", "Pictures", "RealTimePacer"]
