"""A standstill: the sample at which the vehicle has stopped, the detector has fired, and a reasoner is queried."""

from __future__ import annotations

from collections.abc import Sequence

from stucksolver.reasoners.playback import scene_digest

from stucksolver.plan import Decision
from stucksolver.record import LoggedQuery
from stucksolver.scene import Scene, Surroundings
from stucksolver.scene.base_model import FrozenModel

SCREENED_BY = "rules"
"""Source of the answer if the ladder first checks whether to wait, so that the reasoner itself is not queried."""


class Standstill(FrozenModel):
    """One standstill. The first seven fields identify it: the same drive reaches the same tick again.

    Attributes:
        suite: Name of the suite.
        route_id: The route within it.
        seed: Seed of the traffic.
        driver: Name of the driver.
        tick: Frame of the simulator.
        digest: `scene_digest` of the scene.
        scenario: Type of the route's first scenario.
        town: The map.
        at_s: Time since the start of the route (s).
        scene: The scene that the reasoner gets.
        surroundings: The guard's input at this tick, in the map's right-handed frame.
        rules: The rules' decision.
    """

    suite: str
    route_id: str
    seed: int
    driver: str
    tick: int
    digest: str
    scenario: str
    town: str
    at_s: float
    scene: Scene
    surroundings: Surroundings
    rules: Decision

    @property
    def name(self) -> str:
        """Short name, unique within a suite and a driver, for files and messages."""
        return f"{self.route_id}-{self.seed}-{self.digest}"


def moments(questions: Sequence[LoggedQuery]) -> tuple[LoggedQuery, ...]:
    """Return the queries of a drive that are standstills.

    They are the first one that reached the reasoner itself, and the first one for which the rules had a plan. Before
    that, every answer was to wait, so the driver has driven alone. Both may be the same query.
    """
    asked = [
        question for question in questions if question.reasoner != SCREENED_BY and question.surroundings is not None
    ]
    planned = [query for query in asked if query.decision.plan is not None]
    found = {query.number: query for query in (*asked[:1], *planned[:1])}
    return tuple(found.values())


def digest_of(question: LoggedQuery) -> str:
    """Return the digest that identifies the same tick in another drive."""
    return scene_digest(question.scene)
