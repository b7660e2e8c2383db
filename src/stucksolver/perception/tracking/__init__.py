"""From detections of single moments to things that stay the same: who is where, how fast, and since when it stands."""

from stucksolver.perception.tracking.track import Track
from stucksolver.perception.tracking.tracker import ObjectTracker

__all__ = ["ObjectTracker", "Track"]
