"""Builds a map in a process of its own first: the client's library may crash on one that a client has sent, or not end.

python -m carlette.opendrive.trial < map.xodr       0 = the map can be served; otherwise says why not
"""

from __future__ import annotations

import resource
import subprocess
import sys

from carlette.errors import MapError

LONGEST_S = 30.0
"""The largest towns of CARLA at hand are built within 3 s on one core."""
MOST_MEMORY_BYTES = 4 << 30
_NAME = "OpenDriveMap"


def try_out(text: str, longest_s: float = LONGEST_S) -> None:
    """Raises `MapError` with the reason where a map cannot be built, crashes its builder or takes too long."""
    command = [sys.executable, "-m", "carlette.opendrive.trial"]
    try:
        done = subprocess.run(
            command,
            input=text.encode("utf-8", "surrogateescape"),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            timeout=longest_s,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise MapError(f"the map is not built within {longest_s:g} s; give a smaller one") from None
    if done.returncode:
        told = done.stderr.decode(errors="replace").strip().rsplit("\n", 1)[-1][:400]
        raise MapError(told or "building the map crashes the carla library; check its roads, lanes and links")


def main() -> int:
    """Builds all that the server makes of a map when it loads it."""
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY_BYTES, MOST_MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    from carlette.opendrive.document import MapFile
    from carlette.opendrive.roads import RoadNetwork
    from carlette.world.world import World

    try:
        roads = RoadNetwork(MapFile(_NAME, sys.stdin.buffer.read().decode("utf-8", "surrogateescape")))
        places = roads.spawn_points()
        World(roads)
    except Exception as error:  # noqa: BLE001  (whatever it is, it must not happen in the server)
        print(error if isinstance(error, MapError) else f"{type(error).__name__}: {error}", file=sys.stderr)
        return 1
    if not all(one.is_finite() for one in places):
        print("a lane lies nowhere: its coordinates are no numbers", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
