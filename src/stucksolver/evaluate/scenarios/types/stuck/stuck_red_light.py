"""StuckRedLight."""

from __future__ import annotations

from collections.abc import Iterator

from stucksolver.evaluate.scenarios.moves.stuck import StuckAtLight
from stucksolver.evaluate.scenarios.registry import scenario


@scenario
class StuckRedLight(StuckAtLight):
    """The hero's light stays red for ever: nobody but a remote operator may release it, so ask in time."""

    type = "StuckRedLight"
    expected = "ask"
    suspends = frozenset({"blocked"})

    def happen(self) -> Iterator[None]:
        self.hold_lights(green=[])
        yield
