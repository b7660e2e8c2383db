"""Parameters of a scenario type: declared as class attributes, and read from the route file's elements on access.

```python
distance_m = NumberParameter("distance", 120.0, "m")           # <distance value="42"/>
gap_m = RangeParameter("frequency", (20.0, 100.0), "m")        # <frequency from="30" to="60"/>
```
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar

if TYPE_CHECKING:
    from stucksolver_eval.scenarios.scenario import Scenario

T = TypeVar("T")


@dataclass(frozen=True)
class Parameter(ABC, Generic[T]):
    """A descriptor: on a scenario it returns the value, on its class itself.

    Raises `ScenarioError` for an invalid value.
    """

    name: str
    """Name of the XML element."""
    default: T
    unit: str = ""

    def __get__(self, scenario: Scenario | None, owner: type[Any] | None = None) -> T:
        if scenario is None:
            return self  # type: ignore[return-value]
        element = scenario.spec.parameters.get(self.name)
        if element is None:
            return self.default
        try:
            return self.read(element)
        except (KeyError, ValueError) as error:
            from stucksolver_eval.scenarios.scenario import ScenarioError

            raise ScenarioError(f"{scenario.spec.name}: <{self.name}> is {dict(element)}; write {self.form}") from error

    @property
    def form(self) -> str:
        """The form of the element, for error messages."""
        return f'<{self.name} value="..."/>'

    @abstractmethod
    def read(self, element: Mapping[str, str]) -> T:
        """Parse the value. Raises `KeyError` or `ValueError`."""


class NumberParameter(Parameter[float]):
    """`<name value="42"/>`"""

    def read(self, element: Mapping[str, str]) -> float:
        return _finite(element["value"])


class RangeParameter(Parameter[tuple[float, float]]):
    """`<name from="30" to="60"/>`; a single value counts as both."""

    @property
    def form(self) -> str:
        return f'<{self.name} from="..." to="..."/>'

    def read(self, element: Mapping[str, str]) -> tuple[float, float]:
        if "value" in element:
            return (_finite(element["value"]),) * 2
        low, high = _finite(element["from"]), _finite(element["to"])
        if low > high:
            raise ValueError("from is larger than to")
        return low, high


@dataclass(frozen=True)
class ChoiceParameter(Parameter[str]):
    """`<name value="right"/>`, one of `options`."""

    options: tuple[str, ...] = ()

    @property
    def form(self) -> str:
        return f'<{self.name} value="{"|".join(self.options)}"/>'

    def read(self, element: Mapping[str, str]) -> str:
        value = element["value"]
        if value not in self.options:
            raise ValueError(value)
        return value


class TextParameter(Parameter[str]):
    """`<name value="..."/>`"""

    def read(self, element: Mapping[str, str]) -> str:
        return element["value"]


class LocationParameter(Parameter["tuple[float, float, float] | None"]):
    """`<name x=".." y=".." z=".."/>` in CARLA's world frame."""

    @property
    def form(self) -> str:
        return f'<{self.name} x="..." y="..." z="..."/>'

    def read(self, element: Mapping[str, str]) -> tuple[float, float, float]:
        return _finite(element["x"]), _finite(element["y"]), _finite(element.get("z", "0"))


def parameters_of(scenario: type[Scenario]) -> list[Parameter[Any]]:
    """Return the parameters of a type, those of its bases first."""
    found: dict[str, Parameter[Any]] = {}
    for cls in reversed(scenario.__mro__):
        for value in vars(cls).values():
            if isinstance(value, Parameter):
                found[value.name] = value
    return list(found.values())


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(text)
    return value
