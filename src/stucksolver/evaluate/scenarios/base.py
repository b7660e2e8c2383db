"""What every scenario is: a situation staged at the start of the route, and a script that runs from a trigger on."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Any, ClassVar

from stucksolver.evaluate.routes.route import ScenarioSpec
from stucksolver.evaluate.scenarios.setting import Setting

LONG_S = 240.0
"""The time limit of most types."""


class ScenarioError(ValueError):
    """A scenario cannot be played as its specification says; the message names it and the remedy."""


class Unsupported(ScenarioError):
    """This map or blueprint library cannot host the scenario; nothing is put in its place."""


class Scenario(ABC):
    """One situation. A type states its `type`, its parameters (see `parameters`), `stage` and `script`.

    The class's docstring says what the situation is; `trigger` and `simplified` complete the documentation.
    """

    type: ClassVar[str]
    timeout_s: ClassVar[float | None] = LONG_S
    """After this time the scenario counts as failed and ends; while it runs, the test for being blocked is off."""
    starts: ClassVar[str] = "at the trigger point"
    """When what the ego has to react to happens, for the documentation."""
    simplified: ClassVar[str] = ""
    """How it differs from the public benchmark's, for the documentation."""
    needs_map: ClassVar[str] = ""
    """What the map must have, for the documentation."""
    blueprints: ClassVar[tuple[str, ...]] = ()
    """Blueprints it cannot do without."""
    extra_criteria: ClassVar[frozenset[str]] = frozenset()
    """Criteria that count a second time while it runs."""
    keeps_suspended: ClassVar[frozenset[str]] = frozenset()
    """Criteria that stay off after the end, once it has switched them off."""

    def __init__(self, spec: ScenarioSpec, setting: Setting) -> None:
        self.spec = spec
        self.setting = setting
        self.suspended: set[str] = set()
        self.news: list[tuple[str, str, float]] = []
        """(kind, text, value) since `Play` last looked: what the criteria should know."""
        self.trigger_index = setting.route.project(_location(spec))
        self.trigger_s_m = float(setting.route.s_m[self.trigger_index])

    def needs(self, setting: Setting) -> str | None:
        """Why this map or blueprint library cannot host it, or None."""
        return None

    def stage(self) -> None:  # noqa: B027 (many types have nothing to stage)
        """At the start of the route: spawn what must be there, and keep the rest below the ground."""

    @abstractmethod
    def script(self) -> Iterator[None]:
        """From the trigger on, one `yield` a tick; it returns when the scenario is over."""

    def close(self) -> None:  # noqa: B027
        """Undo what outlives the script: lights held, criteria off. Called once, whatever happened before."""

    def disturb(self, control: Any) -> Any:
        """The hero's `carla.VehicleControl` as the vehicle gets it, while the script runs."""
        return control


def _location(spec: ScenarioSpec) -> Any:
    import carla

    place = spec.trigger.position
    return carla.Location(place.x_m, place.y_m, place.z_m)
