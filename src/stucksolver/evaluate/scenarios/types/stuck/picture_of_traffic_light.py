"""PictureOfTrafficLight."""

from __future__ import annotations

from stucksolver.evaluate.scenarios.moves.places import edge_m
from stucksolver.evaluate.scenarios.moves.stuck import Stuck
from stucksolver.evaluate.scenarios.registry import scenario

STOP, POSTER = "static.prop.busstoplb", "static.prop.advertisement"


@scenario
class PictureOfTrafficLight(Stuck):
    """A bus stop shows a picture of a red traffic light: it governs nobody, so go on."""

    type = "PictureOfTrafficLight"
    expected = "recover"
    simplified = "the picture itself is not drawn, so only a perception that errs by itself stops here"
    suspends = frozenset({"blocked"})
    blueprints = (STOP, POSTER)

    def stage(self) -> None:
        aside_m = edge_m(self.ahead(self.distance_m)) + 2.3
        self.put(STOP, 0.0, aside_m, turn_deg=90.0)
        self.put(POSTER, -4.5, aside_m - 1.0, turn_deg=90.0)
