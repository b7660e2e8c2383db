"""Everything public says what it is: modules, classes, functions, methods, properties."""

from __future__ import annotations

import importlib
import inspect
import pkgutil

import pytest

PACKAGES = ["stucksolver", "stucksolver_bridge", "stucksolver_eval", "carlette"]
ELSEWHERE = {"stucksolver_bridge.leaderboard"}
"""Parts that are imported in a Bench2Drive installation only."""
NAMED_BY_CARLA = "carlette.rpc.handlers"
"""Functions there are CARLA's own, by name."""


def public_modules(package):
    for found in pkgutil.walk_packages(importlib.import_module(package).__path__, f"{package}."):
        if not any(found.name.startswith(item) for item in ELSEWHERE) and "__main__" not in found.name:
            yield importlib.import_module(found.name)


def function_of(member):
    if isinstance(member, property):
        return member.fget
    if isinstance(member, (staticmethod, classmethod)):
        return member.__func__
    return getattr(member, "func", member)


def says(owner, name):
    """Whether a method, or one of a base class that it stands for, has a docstring."""
    return any(getattr(vars(base).get(name), "__doc__", None) for base in owner.__mro__)


def silent(module):
    if not module.__doc__:
        yield module.__name__
    for name, thing in vars(module).items():
        if name.startswith("_") or getattr(thing, "__module__", None) != module.__name__:
            continue
        if (inspect.isfunction(thing) or inspect.isclass(thing)) and thing.__name__ == name and not thing.__doc__:
            yield f"{module.__name__}.{name}"
        for member, value in vars(thing).items() if inspect.isclass(thing) else ():
            function = function_of(value)
            of_this = inspect.isfunction(function) and function.__qualname__ == f"{name}.{member}"
            if of_this and not member.startswith("_") and not says(thing, member):
                yield f"{module.__name__}.{name}.{member}"


@pytest.mark.integration
@pytest.mark.parametrize("package", PACKAGES)
def test_everything_public_says_what_it_is(package) -> None:
    for needed in ("carla", "numba"):
        pytest.importorskip(needed)
    found = [item for module in public_modules(package) for item in silent(module)]
    assert [item for item in found if not item.startswith(NAMED_BY_CARLA)] == []
