"""A ride with a passenger: one street in real time."""

from stucksolver_eval.ride.ride import RideOutcome, RideSpec, drive_ride, find_ride
from stucksolver_eval.ride.situations import RIDES, RideCase

__all__ = ["RIDES", "RideCase", "RideOutcome", "RideSpec", "drive_ride", "find_ride"]
