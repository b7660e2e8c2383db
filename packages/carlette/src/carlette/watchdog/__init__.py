"""Keeps clients going whose TrafficManager would otherwise hang: when snapshots are sent, and which clients are woken.

docs/carlette.md, "The TrafficManager's lost wake-up", explains why this exists. The server uses two objects:
`SnapshotPacer` says when a snapshot may be sent, and `TrafficManagerWatchdog` is told what clients do and frees one
that hangs.
"""

from carlette.watchdog.pacing import SnapshotPacer
from carlette.watchdog.traffic_manager import TrafficManagerWatchdog

__all__ = ["SnapshotPacer", "TrafficManagerWatchdog"]
