"""A ride with a passenger: one street at the pace of the clock on the wall."""

from stucksolver_eval.ride.cases import RIDES, RideCase
from stucksolver_eval.ride.ride import RideOutcome, RideSpec, drive_ride, find_ride

__all__ = ["RIDES", "RideCase", "RideOutcome", "RideSpec", "drive_ride", "find_ride"]
