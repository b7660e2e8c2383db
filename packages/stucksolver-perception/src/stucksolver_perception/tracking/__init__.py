"""Tracks detections over time: position, velocity, and the time since which an object is stationary."""

from stucksolver_perception.tracking.track import Track, boxes_of
from stucksolver_perception.tracking.tracker import ObjectTracker

__all__ = ["ObjectTracker", "Track", "boxes_of"]
