"""Frees clients whose TrafficManager would otherwise hang: when snapshots are sent, and which clients are woken.

docs/carlette.md, "The TrafficManager's lost wake-up", explains why this exists. The server uses two objects.
`SnapshotPacer` decides when a snapshot may be sent. `TrafficManagerWatchdog` observes the clients and frees one
that hangs.
"""

from carlette.watchdog.pacing import SnapshotPacer
from carlette.watchdog.traffic_manager import TrafficManagerWatchdog

__all__ = ["SnapshotPacer", "TrafficManagerWatchdog"]
