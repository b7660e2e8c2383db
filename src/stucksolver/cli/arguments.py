"""How all commands read their arguments: what is wrong is one line, and the help names every default."""

from __future__ import annotations

import argparse
import importlib.metadata
import math
from collections.abc import Callable
from typing import Any, NoReturn

EXIT_USAGE = 2
LAST_PORT = 65535
SUPPORTED = "Python 3.10, 3.11 or 3.12 on Linux x86-64"
"""Where CARLA's client package exists."""


class _Formatter(argparse.ArgumentDefaultsHelpFormatter):
    """Adds the default to the help of each option that has one."""

    def _get_help_string(self, action: argparse.Action) -> str | None:
        if action.default in (None, False, (), "", argparse.SUPPRESS) or action.default == []:
            return action.help
        return super()._get_help_string(action)


class Parser(argparse.ArgumentParser):
    """Of a command, and of the commands below it."""

    def __init__(self, **options: Any) -> None:
        options.setdefault("formatter_class", _Formatter)
        super().__init__(**options)

    def error(self, message: str) -> NoReturn:
        """End with one line; the help has the rest."""
        self.exit(EXIT_USAGE, f"error: {message}; see `{self.prog} --help`\n")


def installed_version() -> str:
    """Of this distribution."""
    try:
        return importlib.metadata.version("stucksolver")
    except importlib.metadata.PackageNotFoundError:
        return "0 (not installed)"


def port(text: str) -> int:
    """A TCP port that can be connected to."""
    if not text.isdecimal() or not 1 <= int(text) <= LAST_PORT:
        raise argparse.ArgumentTypeError(f"'{text}' is not a port; give a number from 1 to {LAST_PORT}")
    return int(text)


def add_clock(parser: argparse.ArgumentParser) -> None:
    """How a reasoner's time is counted in a simulation."""
    parser.add_argument("--clock", default="lockstep", help="lockstep, latency:SECONDS or latency:measured")


PERCEPTIONS = ("privileged", "sensors")
"""Where the world is known from: ground truth, or the rig's sensors."""


def add_perception(parser: argparse.ArgumentParser) -> None:
    """Where driver and solver know the world from."""
    parser.add_argument(
        "--perception",
        default=PERCEPTIONS[0],
        choices=PERCEPTIONS,
        help="the simulator's ground truth, or camera, LiDAR, GNSS, IMU and wheels",
    )


def add_map(parser: argparse.ArgumentParser, usual: str) -> None:
    """Where to drive."""
    parser.add_argument("--map", default=usual, help="a town's name or an OpenDRIVE file")
    add_maps(parser)


def add_maps(parser: argparse.ArgumentParser) -> None:
    """Where towns are looked for."""
    parser.add_argument("--maps", help="folders to search for towns, separated by ':'")


def add_server(parser: argparse.ArgumentParser) -> None:
    """A server that runs already, in place of our own."""
    parser.add_argument("--host", help="use the CARLA server at this address instead of starting carlette")
    parser.add_argument("--port", type=port, default=2000, help="of that server")


def whole(text: str) -> int:
    """A whole number."""
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not possible; give a whole number") from None


def at_least(least: int) -> Callable[[str], int]:
    """Whole numbers from this one on."""

    def read(text: str) -> int:
        try:
            found = int(text)
        except ValueError:
            found = least - 1
        if found < least:
            raise argparse.ArgumentTypeError(f"'{text}' is not possible; give a whole number, {least} or more")
        return found

    return read


def above_zero(text: str) -> float:
    """A finite number above 0."""
    try:
        found = float(text)
    except ValueError:
        found = 0.0
    if not (math.isfinite(found) and found > 0.0):
        raise argparse.ArgumentTypeError(f"'{text}' is not possible; give a number above 0")
    return found
