"""Settings of an episode and the weather: values that clients set and read back."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

ASYNCHRONOUS_STEP_S = 0.05
"""Step in asynchronous mode (s). Ours."""


@dataclass(frozen=True)
class EpisodeSettings:
    """`carla.WorldSettings`, in the order of the wire. The defaults are CARLA's."""

    synchronous: bool = False
    no_rendering: bool = False
    fixed_delta_s: float | None = None
    substepping: bool = True
    max_substep_delta_s: float = 0.01
    max_substeps: int = 10
    max_culling_distance_m: float = 0.0
    deterministic_ragdolls: bool = True
    tile_stream_distance_m: float = 3000.0
    actor_active_distance_m: float = 2000.0
    spectator_as_ego: bool = True

    @property
    def step_s(self) -> float:
        """Simulated duration of one tick (s)."""
        return self.fixed_delta_s or ASYNCHRONOUS_STEP_S

    @cached_property
    def single_step_s(self) -> float:
        """`step_s` rounded to the snapshot's float32."""
        return float(np.float32(self.step_s))


CLEAR_NOON = (5.0, 0.0, 0.0, 10.0, -1.0, 45.0, 2.0, 0.75, 0.1, 0.0, 1.0, 0.03, 0.0331, 0.0)
"""The 14 numbers of `carla.WeatherParameters` at the start of an episode."""
