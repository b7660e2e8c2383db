"""What a page is sent, also one that is slow."""

from __future__ import annotations

import asyncio

import pytest

pytest.importorskip("fastapi")

from stucksolver_passenger.server.event_stream import events
from stucksolver_passenger.server.fleet_state import Board
from stucksolver_passenger.socket_frames import LONGEST, SocketMessage, SocketMessageError, Topic, body_length, unpacked


def view(number):
    return SocketMessage(Topic.VIEW, "car-1", b'{"frame":%d}' % number)


def board():
    made = Board()
    made.take(SocketMessage(Topic.HELLO, "car-1", b"Car 1"), lambda data: None)
    return made


async def always_there():
    return False


def test_event_stream_slow_page_gets_only_newest_view():
    """A slow page gets the newest view; older ones are not kept for it."""

    async def run():
        here = board()
        stream = events(here, "car-1", True, always_there)
        assert await anext(stream) == 'event: hello\ndata: "Car 1"\n\n'
        here.take(view(1), lambda data: None)
        first = await anext(stream)
        for number in range(2, 500):
            here.take(view(number), lambda data: None)
        return first, await anext(stream)

    first, second = asyncio.run(run())
    assert first == 'event: view\ndata: {"frame":1}\n\n'
    assert second == 'event: view\ndata: {"frame":499}\n\n'


def test_who_wants_no_pictures_gets_words_only():
    async def run():
        here = board()
        here.take(view(1), lambda data: None)
        here.take(SocketMessage(Topic.PICTURE, "car-1", b"abcd"), lambda data: None)
        here.take(SocketMessage(Topic.SCENERY, "car-1", b"{}"), lambda data: None)
        stream = events(here, "car-1", False, always_there)
        return [await anext(stream) for _ in range(2)][1]

    assert asyncio.run(run()) == "event: scenery\ndata: {}\n\n"


def test_a_car_that_comes_again_is_shown_from_the_start():
    async def run():
        here = board()
        here.take(SocketMessage(Topic.SCENERY, "car-1", b"[1]"), lambda data: None)
        stream = events(here, "car-1", True, always_there)
        before = [await anext(stream) for _ in range(2)]
        here.take(SocketMessage(Topic.HELLO, "car-1", b"Car 1, again"), lambda data: None)
        here.take(SocketMessage(Topic.SCENERY, "car-1", b"[2]"), lambda data: None)
        return before + [await anext(stream) for _ in range(2)]

    told = asyncio.run(run())
    assert "[1]" in told[1] and "Car 1, again" in told[2] and "[2]" in told[3]


def test_a_page_that_has_gone_is_not_served_any_more():
    async def run():
        async def gone():
            return True

        return [text async for text in events(board(), "car-1", True, gone)]

    assert asyncio.run(run()) == []


def test_a_frame_comes_back_as_it_was():
    packed = view(7).packed()
    assert body_length(packed[:4]) == len(packed) - 4
    assert unpacked(packed[4:]) == view(7)


@pytest.mark.parametrize("head", [b"\0\0\0\0", (LONGEST + 1).to_bytes(4, "big"), b"GET "])
def test_what_is_no_length_of_a_frame_is_refused(head):
    with pytest.raises(SocketMessageError):
        body_length(head)


def test_an_unknown_topic_is_refused():
    with pytest.raises(SocketMessageError, match="unknown topic"):
        unpacked(b"shout car-1\n{}")
