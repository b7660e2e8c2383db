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
def test_the_example_of_the_page_runs_and_a_fork_goes_on_as_the_original_would():
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
def test_the_same_seed_puts_the_same_cars_at_the_same_places():
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


def test_traffic_drives_on_in_a_fork_and_not_in_the_world_it_came_from():
    world = open_world("demo_town", seed=2)
    populate(world, 5, seed=2)
    world.traffic = Traffic(world, seed=2)
    before = world.bodies.position.copy()
    branch = world.fork()
    for _ in range(100):
        branch.tick()
    assert np.array_equal(world.bodies.position, before)
    assert not np.array_equal(branch.bodies.position, before)
