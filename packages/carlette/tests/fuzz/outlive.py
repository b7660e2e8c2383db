"""A client whose server is killed: it gets an error, and a new client of the same process works with the next server.

Usage: outlive.py PORT. Says where it is on standard output.
"""

from __future__ import annotations

import sys
from typing import Any

import carla


def ticking(port: int) -> Any:
    client = carla.Client("127.0.0.1", port)
    client.set_timeout(60.0)
    world = client.get_world()
    settings = world.get_settings()
    settings.synchronous_mode, settings.fixed_delta_seconds = True, 0.05
    world.apply_settings(settings)
    world.tick()
    return client, world


def main(port: int) -> None:
    old = ticking(port)
    print("ticking", flush=True)
    old[0].set_timeout(1.0)
    try:
        while True:
            old[1].tick()
    except RuntimeError:
        print("error", flush=True)
    sys.stdin.readline()
    new = ticking(port)
    frames = [new[1].tick() for _ in range(20)]
    assert frames == list(range(frames[0], frames[0] + 20))
    print("ticking again", flush=True)
    sys.stdin.readline()


if __name__ == "__main__":
    main(int(sys.argv[1]))
