"""Estimates the vehicle's pose from satellites, inertial sensors and wheels in one filter, and its lane."""

from stucksolver_perception.localization.ekf_localizer import EkfLocalizer, NotLocalizedError
from stucksolver_perception.localization.lane_matching import LaneMatch, match

__all__ = ["EkfLocalizer", "LaneMatch", "NotLocalizedError", "match"]
