"""Worlds without a client: the example of the page, and what it promises."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from carlette.errors import MapError
from carlette.in_process import Traffic, open_world, populate

PAGE = Path(__file__).parents[3] / "docs" / "carlette.md"


@pytest.mark.integration
def test_documentation_example_runs_and_fork_matches_original():
    """The example of the page runs, and its fork continues as the original would."""
    (example,) = [
        e for e in re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL) if "in_process" in e
    ]
    told: dict[str, object] = {}
    exec(compile(example, str(PAGE), "exec"), told)
    world, branch = told["world"], told["branch"]
    assert len(told["cars"]) == 20
    assert np.hypot(*(branch.bodies.position - world.bodies.position)[:, :2].T).max() > 10.0
    for _ in range(200):
        world.tick()
    assert np.array_equal(world.bodies.position, branch.bodies.position)


@pytest.mark.integration
def test_populate_is_reproducible_by_seed():
    """The same seed places the same cars at the same positions."""
    first, second, other = (open_world("grid_town") for _ in range(3))
    for world, seed in ((first, 3), (second, 3), (other, 4)):
        assert len(populate(world, 8, seed)) == 8
    assert np.array_equal(first.bodies.position, second.bodies.position)
    assert not np.array_equal(first.bodies.position, other.bodies.position)


def test_where_there_is_no_more_room_there_are_fewer_cars():
    world = open_world("demo_town")
    assert 0 < len(populate(world, 10_000)) < 10_000


def test_a_town_that_does_not_exist_is_named():
    with pytest.raises(MapError, match="Nowhere"):
        open_world("Nowhere")


def test_traffic_continues_in_fork_but_not_in_original():
    """Traffic continues in a fork and not in the original."""
    world = open_world("demo_town", seed=2)
    populate(world, 5, seed=2)
    world.traffic = Traffic(world, seed=2)
    before = world.bodies.position.copy()
    branch = world.fork()
    for _ in range(100):
        branch.tick()
    assert np.array_equal(world.bodies.position, before)
    assert not np.array_equal(branch.bodies.position, before)
