"""From single detections to persistent tracks: where, how fast, and since when they stand."""

from stucksolver.perception.tracking.track import Track
from stucksolver.perception.tracking.tracker import ObjectTracker

__all__ = ["ObjectTracker", "Track"]
