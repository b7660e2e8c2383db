"""Traffic without a client: cars that follow their lanes, for worlds that are stepped in-process."""

from carlette.traffic.autopilot import Traffic

__all__ = ["Traffic"]
