"""Whatever one client sends, the server lives, answers it, and serves the next one at once."""

from __future__ import annotations

import random
import socket
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from nonsense import (
    Healthy,
    actor_ids,
    fixed_calls,
    frames_of_noise,
    likely_arguments,
    likely_commands,
    method_names,
    resets,
    shapes,
)

from raw_client import Raw
from serving import running_server

pytestmark = pytest.mark.integration
pytest.importorskip("carla")

FUZZ = settings(max_examples=100, derandomize=True, suppress_health_check=list(HealthCheck))


@pytest.fixture(scope="module")
def port(tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    # Recordings are files in the folder in which the server was started.
    with running_server("--map", "demo_town", folder=tmp_path_factory.mktemp("fuzz")) as port:
        yield port


@pytest.fixture(scope="module")
def healthy(port: int) -> Iterator[Healthy]:
    one = Healthy(port)
    yield one
    one.close()


@FUZZ
@given(noise=frames_of_noise(), to_stream=st.booleans(), is_reset=st.booleans())
def test_noise_on_either_port(port: int, healthy: Healthy, noise: bytes, to_stream: bool, is_reset: bool) -> None:
    with socket.create_connection(("127.0.0.1", port + to_stream), timeout=60) as sock:
        if is_reset:
            resets(sock)
        sock.sendall(noise)
    healthy.check()


@pytest.mark.parametrize("method", method_names())
def test_every_method_answers_any_arguments(port: int, healthy: Healthy, method: str) -> None:
    chance = random.Random(method)
    raw = Raw(port)
    actors = actor_ids(raw)
    for _ in range(8):
        raw.call(method, *likely_arguments(chance, method, actors))
        raw.call(method, *(shapes(chance, actors) for _ in range(chance.randrange(5))))
    raw.socket.close()
    healthy.check()


@FUZZ
@given(seed=st.integers(0, 2**32))
def test_the_commands_of_a_batch_are_answered_one_for_one(port: int, healthy: Healthy, seed: int) -> None:
    chance = random.Random(seed)
    raw = Raw(port)
    commands = likely_commands(chance, actor_ids(raw))
    error, answers = raw.call("apply_batch", commands, chance.random() < 0.2)
    assert error is None and len(answers) == len(commands)
    raw.socket.close()
    healthy.check()


@pytest.mark.parametrize("call", fixed_calls(), ids=lambda call: f"{call[0]}-{call[1]}")
def test_numbers_that_are_none_never_come_back_in_a_snapshot(
    port: int, healthy: Healthy, call: tuple[Any, ...]
) -> None:
    method, *arguments = call
    raw = Raw(port)
    for actor in actor_ids(raw):
        raw.call(method, actor, *arguments)
    healthy.check()
    healthy.check()
    raw.socket.close()
    healthy.load_new_world()
