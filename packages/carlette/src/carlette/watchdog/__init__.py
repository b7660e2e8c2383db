"""What keeps clients going whose TrafficManager would hang: when snapshots are sent, and who is woken.

Why this exists stands in docs/carlette.md, "The TrafficManager's lost wake-up". The server needs two objects of it:
`Pacing` tells when a snapshot may go out, `TrafficManagerWatchdog` is told what clients do and frees one that hangs.
"""

from carlette.watchdog.pacing import Pacing
from carlette.watchdog.traffic_manager import TrafficManagerWatchdog

__all__ = ["Pacing", "TrafficManagerWatchdog"]
