"""Where the vehicle is: satellites, inertial sensors and wheels in one filter, and which lane that is."""

from stucksolver.perception.localisation.lanes import LaneMatch, match
from stucksolver.perception.localisation.localiser import Localiser, NotLocalisedError

__all__ = ["LaneMatch", "Localiser", "NotLocalisedError", "match"]
