"""The recorder and the replayer. As in CARLA, they answer with texts, even if a file is missing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from carlette.errors import RequestError
from carlette.recorder import LogRecorder, Replay, make_room, path_in, read_tape, report
from carlette.rpc.registry import Methods
from carlette.rpc.session import ClientSession
from carlette.simulator import Simulator

methods = Methods()


@methods.value("start_recorder")
def start_recorder(session: ClientSession, name: str, additional: bool = False) -> str:
    del additional  # there is nothing more to record
    stop_recorder(session)
    return _text_or_error(lambda: _begin(session.simulator, _path(session, name)))


def _begin(simulator: Simulator, path: Path) -> str:
    make_room(path)
    simulator.recorder = LogRecorder(path, simulator.world)
    return str(path)


@methods.void("stop_recorder")
def stop_recorder(session: ClientSession) -> None:
    if session.simulator.recorder is not None:
        session.simulator.recorder.stop()
        session.simulator.recorder = None


@methods.value("show_recorder_file_info")
def show_recorder_file_info(session: ClientSession, name: str, show_all: bool = False) -> str:
    return _text_or_error(lambda: report.file_info(read_tape(_path(session, name)), show_all))


@methods.value("show_recorder_collisions")
def show_recorder_collisions(session: ClientSession, name: str, first: Any = "a", second: Any = "a") -> str:
    return _text_or_error(lambda: report.collisions(read_tape(_path(session, name)), _letter(first), _letter(second)))


@methods.value("show_recorder_actors_blocked")
def show_recorder_actors_blocked(
    session: ClientSession, name: str, least_s: float = 30.0, least_m: float = 10.0
) -> str:
    return _text_or_error(lambda: report.blocked(read_tape(_path(session, name)), float(least_s), float(least_m)))


@methods.value("replay_file")
def replay_file(
    session: ClientSession, name: str, start_s: float, duration_s: float, follow_id: int, *more: Any
) -> str:
    """Begin to replay a recorded file in the session's world; a replay that still runs ends.

    Args:
        session: The client's session.
        name: The name of the file, as in `start_recorder`.
        start_s: The start of the replay (s); a negative number counts from the end of the recording.
        duration_s: The length of the replay (s); 0 means up to the end.
        follow_id: Recorded id of the actor that the spectator follows; 0 for none.
        *more: Further arguments of newer clients. They are ignored.

    Returns:
        A text for people: what is replayed, or why the file cannot be replayed.
    """
    del more  # whether to replay sensors, which are not recorded, and (0.9.16) the point from which to follow
    simulator = session.simulator

    def begin() -> str:
        tape, options = read_tape(_path(session, name)), simulator.replay_options
        replay = Replay(tape, simulator.world, float(start_s), float(duration_s), int(follow_id), options)
        simulator.end_replay(keep_actors=False)
        simulator.replay = replay
        return f"Replaying file {_path(session, name)} from {replay.time_s:g} to {replay.end_s:g} seconds"

    return _text_or_error(begin)


@methods.void("stop_replayer")
def stop_replayer(session: ClientSession, keep_actors: bool = False) -> None:
    session.simulator.end_replay(bool(keep_actors))


@methods.void("set_replayer_time_factor")
def set_replayer_time_factor(session: ClientSession, factor: float) -> None:
    if not 0.0 <= factor <= 1000.0:
        raise RequestError(f"set_replayer_time_factor: {factor} is not a factor from 0 to 1000")
    session.simulator.replay_options.time_factor = float(factor)


@methods.void("set_replayer_ignore_hero")
def set_replayer_ignore_hero(session: ClientSession, ignore: bool) -> None:
    session.simulator.replay_options.ignores_hero = bool(ignore)


@methods.void("set_replayer_ignore_spectator")
def set_replayer_ignore_spectator(session: ClientSession, ignore: bool) -> None:
    session.simulator.replay_options.ignores_spectator = bool(ignore)


def _text_or_error(tell: Callable[[], str]) -> str:
    try:
        return tell()
    except RequestError as error:
        # CARLA also returns the error as a text.
        return str(error)


def _path(session: ClientSession, name: str) -> Path:
    return path_in(session.simulator.recordings, name)


def _letter(kind: Any) -> str:
    """Return a character that arrives as a number or as a text."""
    return chr(kind) if isinstance(kind, int) else str(kind)
