"""Traffic lights: the phases of each junction, their times, and colors that clients set by hand."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum
from random import Random

import numpy as np
from numpy.typing import NDArray

from carlette.geometry import Floats
from carlette.opendrive.signals import SignalPhase
from carlette.physics.bodies import BodyTable
from carlette.physics.column_table import Table, flags, indices, numbers

GREEN_S = 10.0
"""Duration of green (s). As in CARLA."""
YELLOW_S = 3.0
"""Duration of yellow (s). As in CARLA."""
RED_S = 2.0
"""Duration of red (s). As in CARLA."""
RED_ALONE_S = 10.0
"""Duration of red for a light without a controller (s).

Such a light does not wait for another light's green.
"""


class Color(IntEnum):
    """`carla.TrafficLightState`."""

    RED = 0
    YELLOW = 1
    GREEN = 2
    OFF = 3
    UNKNOWN = 4


STAGES = (Color.GREEN, Color.YELLOW, Color.RED)
"""The stages of a phase, in the order of the columns of `Lights.times`."""


@dataclass
class LightGroup:
    """The lights of a junction. Its phases turn green one after the other."""

    phases: list[list[int]]
    """Indices of the lights that are green together."""
    red_s: float = RED_S
    phase: int = 0
    """Index of the present phase."""
    stage: int = 0
    """Index of the present stage in `STAGES`."""
    elapsed_s: float = 0.0
    """Time since the start of the stage (s)."""
    due_s: float | None = None
    """Duration of the stage: the longest time of the phase's lights (s); None = to be looked up."""


@dataclass
class Lights(Table):
    """One row for each traffic light."""

    row: NDArray[np.int64] = field(default_factory=indices())
    """Row of the light in `BodyTable`."""
    group: NDArray[np.int64] = field(default_factory=indices())
    color: NDArray[np.int64] = field(default_factory=indices())
    elapsed: Floats = field(default_factory=numbers())
    """Time since the color changed (s)."""
    times: Floats = field(default_factory=numbers(3))
    """Times of green, yellow and red (s)."""
    frozen: NDArray[np.bool_] = field(default_factory=flags())
    by_hand: NDArray[np.bool_] = field(default_factory=flags())
    """True if a client set the color. It stays for that color's time, then the group controls the light again."""
    center: Floats = field(default_factory=numbers(3))
    """Center of the trigger box, world frame (m)."""
    ahead: Floats = field(default_factory=numbers(2))
    """Unit vector ahead of the trigger box."""
    extent: Floats = field(default_factory=numbers(3))
    """Half sizes of the trigger box (m)."""


class Signals:
    """All traffic lights of the world and their groups."""

    def __init__(self) -> None:
        self.lights = Lights()
        self.groups: list[LightGroup] = []
        self._is_news = True
        """True if anything but the time has changed since the last publication."""
        self._is_held = False
        """True if a light may be set by hand. It is checked first, because scanning the column costs more."""

    def form_groups(self, turns: list[SignalPhase], random: Random) -> None:
        """Group the lights by their turns; each group starts in a phase drawn at random."""
        by_group: dict[str, dict[int, list[int]]] = {}
        for index, turn in enumerate(turns):
            by_group.setdefault(turn.group, {}).setdefault(turn.phase, []).append(index)
        alone = {turn.group for turn in turns if turn.alone}
        for number, (name, members) in enumerate(by_group.items()):
            ordered = [members[key] for key in sorted(members)]
            red_s = RED_ALONE_S if name in alone else RED_S
            self.groups.append(LightGroup(ordered, red_s, phase=random.randrange(len(ordered))))
            for index in (item for phase in ordered for item in phase):
                self.lights.group[index] = number
        self.reset(range(len(self.groups)), keep_phase=True)

    def reset(self, numbers_: range | list[int], keep_phase: bool = False) -> None:
        """Restart groups: the first phase turns green, all others red; times are those of the start."""
        lights = self.lights
        for number in numbers_:
            group = self.groups[number]
            self._is_news = True
            group.phase = group.phase if keep_phase else 0
            group.stage, group.elapsed_s, group.due_s = 0, 0.0, None
            for index in (item for phase in group.phases for item in phase):
                lights.by_hand[index] = False
                lights.times[index] = (GREEN_S, YELLOW_S, group.red_s)
                self._paint(index, Color.GREEN if index in group.phases[group.phase] else Color.RED)

    def set_color(self, index: int, color: Color) -> None:
        """Set a light by hand."""
        self._paint(index, color)
        self.lights.by_hand[index] = self._is_held = True

    def set_time(self, index: int, stage: Color, seconds: float) -> None:
        """Set the time for which a light stays green, yellow or red."""
        self.lights.times[index, STAGES.index(stage)] = seconds
        self._is_news = True
        self.groups[self.lights.group[index]].due_s = None

    def freeze(self, frozen: bool, index: int | None = None) -> None:
        """Stop or restart the clock of all lights, or of the group of one."""
        lights = self.lights
        self._is_news = True
        if index is None:
            lights.frozen[:] = frozen
        else:
            lights.frozen[lights.group == lights.group[index]] = frozen

    def members(self, index: int) -> list[int]:
        """Return the lights of the same group."""
        return [item for phase in self.groups[self.lights.group[index]].phases for item in phase]

    def step(self, bodies: BodyTable, dt: float) -> None:
        """Advance the time of all lights."""
        lights = self.lights
        if not len(lights):
            return
        lights.elapsed += np.where(lights.frozen, 0.0, dt)
        if self._is_held:
            self._release()
        for group in self.groups:
            if not lights.frozen[group.phases[0][0]]:
                # In 32 bits, as CARLA counts: at 20 Hz yellow lasts 61 ticks and red 41, so a phase lasts 15.1 s.
                group.elapsed_s = float(np.float32(group.elapsed_s) + np.float32(dt))
                self._advance(group)
        self.publish(bodies)

    def publish(self, bodies: BodyTable) -> None:
        """Write colors and times into the records."""
        lights, record = self.lights, bodies.record
        record["elapsed"][lights.row] = lights.elapsed
        if not self._is_news:
            return
        self._is_news = False
        record["color"][lights.row] = lights.color
        record["light_times"][lights.row] = lights.times
        record["frozen"][lights.row] = lights.frozen

    def _advance(self, group: LightGroup) -> None:
        lights = self.lights
        if group.due_s is None:
            group.due_s = float(lights.times[group.phases[group.phase], group.stage].max())
        if group.elapsed_s <= group.due_s:
            return
        group.elapsed_s, group.due_s = 0.0, None
        self._is_news = True
        group.stage = (group.stage + 1) % len(STAGES)
        if group.stage == 0:
            group.phase = (group.phase + 1) % len(group.phases)
        for index in group.phases[group.phase]:
            if not lights.by_hand[index]:
                self._paint(index, STAGES[group.stage])

    def _release(self) -> None:
        lights = self.lights
        for index in np.flatnonzero(lights.by_hand).tolist():
            color = Color(int(lights.color[index]))
            if color in STAGES and lights.elapsed[index] >= lights.times[index, STAGES.index(color)]:
                lights.by_hand[index] = False
                group = self.groups[lights.group[index]]
                current = index in group.phases[group.phase]
                self._paint(index, STAGES[group.stage] if current else Color.RED)
        self._is_held = bool(lights.by_hand.any())

    def _paint(self, index: int, color: Color) -> None:
        self._is_news = True
        self.lights.color[index] = color
        self.lights.elapsed[index] = 0.0
