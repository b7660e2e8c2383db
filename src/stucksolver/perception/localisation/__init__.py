"""The vehicle's pose from satellites, inertial sensors and wheels in one filter, and its lane."""

from stucksolver.perception.localisation.lanes import LaneMatch, match
from stucksolver.perception.localisation.localiser import Localiser, NotLocalisedError

__all__ = ["LaneMatch", "Localiser", "NotLocalisedError", "match"]
