"""The point on rails of `examples/own_stack.py`, speaking JSON forms instead of calling the solver."""

from __future__ import annotations

import importlib.util
from pathlib import Path

from stucksolver.plan.directive import CONTINUE, directive_adapter
from stucksolver.plan.json_schemas import ADAPTERS

EXAMPLE = Path(__file__).resolve().parents[4] / "examples" / "own_stack.py"


def _example():
    spec = importlib.util.spec_from_file_location("own_stack", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Street:
    """A street with a parked car."""

    def __init__(self) -> None:
        self._stack = _example().PointStack()
        self._directive = CONTINUE
        self.directive = {"kind": "continue"}

    @property
    def x(self) -> float:
        return self._stack.x

    @property
    def y(self) -> float:
        return self._stack.y

    @property
    def time_s(self) -> float:
        return self._stack.time_s

    def status(self):
        return _form("status", self._stack.status())

    def give(self, what):
        return _form(what, getattr(self._stack, what)())

    def perform(self, changed) -> None:
        if changed is not None:
            self.directive, self._directive = changed, directive_adapter.validate_python(changed)
        self._stack.perform(self._directive)


def _form(name, value):
    return ADAPTERS[name].dump_python(value, mode="json")
