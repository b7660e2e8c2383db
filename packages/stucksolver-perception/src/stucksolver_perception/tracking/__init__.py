"""From single detections to persistent tracks: position, velocity, and since when they have been stationary."""

from stucksolver_perception.tracking.track import Track, boxes_of
from stucksolver_perception.tracking.tracker import ObjectTracker

__all__ = ["ObjectTracker", "Track", "boxes_of"]
