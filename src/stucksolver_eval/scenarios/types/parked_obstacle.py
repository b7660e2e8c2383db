"""ParkedObstacle."""

from __future__ import annotations

from stucksolver_eval.scenarios.moves.obstacle import Obstacle
from stucksolver_eval.scenarios.registry import scenario

OFFSET = 0.7


class ParkedCar(Obstacle):
    """One car with its hazard lights on."""

    def put(self) -> tuple[float, float]:
        car = self.park(self.new_car(), self.distance_m, OFFSET)
        self.hazard_lamps(car)
        return self.distance_m, self.distance_m


@scenario
class ParkedObstacle(ParkedCar):
    """A car with hazard lights stands in the hero's lane; it must change to the lane beside."""

    type = "ParkedObstacle"
    starts = "the car stands from the start; the traffic beside slows 5 s after the hero came within 50 m"
