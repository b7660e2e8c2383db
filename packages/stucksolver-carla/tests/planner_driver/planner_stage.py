"""The driver's world without a server, with a clock, lamps and what the planner asks besides."""

from __future__ import annotations

from types import SimpleNamespace

from behavior_driver.fakes import TICK_S, FakeWorld
from behavior_driver.roads import LANE_Y, straight_road

LEFT, RIGHT, ONCOMING = LANE_Y[-1], LANE_Y[-2], LANE_Y[1]


class LitWorld(FakeWorld):
    """Actors with lamps on the straight road of two lanes forward and one back."""

    def __init__(self):
        super().__init__(straight_road())
        self.lamps = {}
        self.time_s = 0.0

    def get_snapshot(self):
        snapshot = super().get_snapshot()
        snapshot.timestamp = SimpleNamespace(delta_seconds=TICK_S, elapsed_seconds=self.time_s)
        return snapshot

    def get_vehicles_light_states(self):
        return self.lamps

    def tick(self):
        super().tick()
        self.time_s += TICK_S


def drive(world, ego, driver, seconds):
    """Let it drive; its x, y and speed on each tick."""
    seen = []
    for _ in range(round(seconds / TICK_S)):
        ego.apply_control(driver.run_step())
        world.tick()
        seen.append((ego.x, ego.y, ego.speed))
    return seen
