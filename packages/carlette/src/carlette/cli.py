"""The command `carlette`."""

from __future__ import annotations

import argparse
import importlib.metadata
import importlib.util
import logging
import os
import select
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from carlette.client_versions import DEFAULT_VERSION, VERSIONS
from carlette.errors import StartupError

if TYPE_CHECKING:
    from carlette.simulator import Simulator

DEFAULT_PORT = 2000
DEFAULT_MAP = "demo_town"
LOOPBACK = ("127.0.0.1", "localhost", "::1")
EXIT_USAGE = 2
LAST_PORT = 65534
NEEDED = ("carla", "msgpack", "numba", "shapely")
"""Modules that every map needs. Cameras need the extra `camera`, and report if it is missing."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return the exit code."""
    options = _parser().parse_args(arguments)
    logging.basicConfig(level=logging.WARNING, format="carlette: %(message)s", stream=sys.stderr)
    try:
        _require_python()
        if options.as_carla_root is None:
            _require_packages()
        return _serve(options) if options.as_carla_root is None else _write_root(options)
    except StartupError as error:
        # The user gets one line instead of a traceback.
        print(f"carlette: error: {error}", file=sys.stderr)
        return EXIT_USAGE


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """End with one line. The help contains the rest."""
        self.exit(EXIT_USAGE, f"carlette: error: {message}; see `carlette --help`\n")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="carlette", description="A headless simulator for the unmodified CARLA client.", allow_abbrev=False
    )
    parser.add_argument("--version", action="version", version=f"%(prog)s {_version()}")
    parser.add_argument(
        "--port",
        type=_port,
        default=DEFAULT_PORT,
        help="request port; the next one is for streaming; 0 = any (default: 2000)",
    )
    parser.add_argument(
        "--map", default=DEFAULT_MAP, metavar="TOWN_OR_FILE", help="town's name or .xodr file (default: demo_town)"
    )
    parser.add_argument(
        "--maps", action="append", default=[], metavar="DIRS", help=f"folders with towns, separated by '{os.pathsep}'"
    )
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on (default: %(default)s)")
    parser.add_argument(
        "--client-version",
        choices=sorted(VERSIONS),
        default=DEFAULT_VERSION,
        help="version of the carla package that connects (default: %(default)s)",
    )
    parser.add_argument(
        "--seed",
        type=int,
        default=0,
        help="seed of random choices, such as first light phases (default: %(default)s)",
    )
    parser.add_argument(
        "--recordings",
        type=Path,
        metavar="DIR",
        help="where clients record to (default: a folder in your state directory)",
    )
    parser.add_argument(
        "--as-carla-root", metavar="DIR", help="write a folder that tools accept as CARLA_ROOT, and exit"
    )
    parser.add_argument(
        "--build-scenery",
        action="store_true",
        help="listen only after the map data for cameras and rays is built (default: build it in the background)",
    )
    parser.add_argument(
        "--synchronous",
        action="store_true",
        help="start in synchronous mode: the world waits until a client ticks it, so that every run starts alike",
    )
    parser.add_argument("--parent-pid", type=int, metavar="PID", help="stop when this process has ended")
    parser.add_argument("--exit-on-stdin-eof", action="store_true", help="stop when standard input closes")
    return parser


def _port(text: str) -> int:
    if not text.isdecimal() or int(text) > LAST_PORT:
        raise argparse.ArgumentTypeError(f"not a port: '{text}'. Give a number from 0 to {LAST_PORT}")
    return int(text)


def _version() -> str:
    """Return the version of the distribution."""
    try:
        return importlib.metadata.version("carlette")
    except importlib.metadata.PackageNotFoundError:
        # A source tree that is not installed has no version.
        return "0 (not installed)"


def _require_python() -> None:
    if not (3, 10) <= sys.version_info[:2] <= (3, 12):
        found = ".".join(map(str, sys.version_info[:2]))
        raise StartupError(f"no wheel of the 'carla' package for Python {found}. Run carlette with Python 3.10-3.12")


def _require_packages() -> None:
    missing = [name for name in NEEDED if not _is_there(name)]
    if missing:
        raise StartupError(f"not installed: {', '.join(missing)}. Run pip install {' '.join(missing)}")


def _is_there(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except ModuleNotFoundError:
        # A parent package of the module is missing.
        return False


def _write_root(options: argparse.Namespace) -> int:
    from carlette.carla_root import write_carla_root
    from carlette.opendrive.map_file import map_folders

    folders = map_folders([item for many in options.maps for item in many.split(os.pathsep)])
    towns = write_carla_root(Path(options.as_carla_root), folders, options.client_version)
    print(f"carlette: {options.as_carla_root} is a CARLA_ROOT with {', '.join(towns)}")
    return 0


def _serve(options: argparse.Namespace) -> int:
    # The imports are late, so that a missing package is reported in one line and `--help` is fast.
    from carlette.allocator import use_single_arena
    from carlette.server import Server

    use_single_arena()
    simulator = _simulator(options)
    if options.build_scenery:
        simulator.build_scenery()
    server = Server(simulator, options.host, options.port)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: server.stop())
    if options.host not in LOOPBACK:
        warning = "every client that can connect controls this server: the protocol has no authentication"
        print(f"carlette: warning: listening on {options.host}; {warning}", file=sys.stderr)
    print(f"carlette: listening on {options.host}:{server.port} map={simulator.world.roads.file.name}", flush=True)
    server.serve(_watchdog(options))
    return 0


def _simulator(options: argparse.Namespace) -> Simulator:
    from carlette.opendrive.faults import warning_of
    from carlette.opendrive.map_file import check_opendrive, find_map, map_folders
    from carlette.simulator import Simulator
    from carlette.world.map_trial import LONGEST_AT_START_S, open_roads
    from carlette.world.settings import EpisodeSettings

    folders = map_folders([item for many in options.maps for item in many.split(os.pathsep)])
    file = find_map(options.map, folders)
    # Only the simulator refers to the first map, so that it is freed with its episode.
    roads = open_roads(file, LONGEST_AT_START_S)
    if warning := warning_of(check_opendrive(file.text, file.source)):
        print(f"carlette: warning: map '{file.source}': {warning}", file=sys.stderr)
    simulator = Simulator(roads, VERSIONS[options.client_version], folders, options.seed, options.recordings)
    simulator.world.settings = EpisodeSettings(synchronous=options.synchronous)
    return simulator


def _watchdog(options: argparse.Namespace) -> Callable[[], bool]:
    """Return a callable that is true while the parent process and standard input exist."""

    def alive() -> bool:
        if options.parent_pid is not None and not _exists(options.parent_pid):
            return False
        return not (options.exit_on_stdin_eof and _stdin_closed())

    return alive


def _exists(pid: int) -> bool:
    # A dead parent may stay as a zombie, or its number may be reused, but its child is adopted by another process.
    if os.getppid() == pid:
        return True
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        # The process has ended.
        return False
    except PermissionError:
        # The process exists and belongs to another user.
        return True
    return not _is_zombie(pid)


def _is_zombie(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as stat:
            return stat.read().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        # The process has ended, so it is no zombie.
        return False


def _stdin_closed() -> bool:
    try:
        ready, _, _ = select.select([sys.stdin.fileno()], [], [], 0.0)
        return bool(ready) and not os.read(sys.stdin.fileno(), 4096)
    except (OSError, ValueError):
        # A closed or invalid descriptor counts as closed.
        return True
