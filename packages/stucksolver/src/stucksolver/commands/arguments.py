"""Arguments that commands share. A usage error is one line, and the help lists every default."""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import math
from collections.abc import Callable
from typing import Any, NoReturn

EXIT_USAGE = 2
"""Exit code for wrong usage or invalid input."""
LAST_PORT = 65535
SUPPORTED = "Python 3.10, 3.11 or 3.12 on Linux x86-64"
"""Platforms for which CARLA's client package is published."""


class _Formatter(argparse.ArgumentDefaultsHelpFormatter):
    """Formatter that adds the default to the help of each option that has one."""

    def _get_help_string(self, action: argparse.Action) -> str | None:
        if action.default in (None, False, (), "", argparse.SUPPRESS) or action.default == []:
            return action.help
        return super()._get_help_string(action)


class Parser(argparse.ArgumentParser):
    """Argument parser with errors of one line; subcommands use it too."""

    def __init__(self, **options: Any) -> None:
        options.setdefault("formatter_class", _Formatter)
        super().__init__(**options)

    def error(self, message: str) -> NoReturn:
        """Exit with `EXIT_USAGE` and one line that points to the help."""
        self.exit(EXIT_USAGE, f"error: {message}; see `{self.prog} --help`\n")


def installed_version() -> str:
    """Return the version of the installed distribution, or a placeholder if it is not installed."""
    try:
        return importlib.metadata.version("stucksolver")
    except importlib.metadata.PackageNotFoundError:
        return "0 (not installed)"


def port(text: str) -> int:
    """Parse a TCP port from 1 to 65535. Raises `argparse.ArgumentTypeError`."""
    if not text.isdecimal() or not 1 <= int(text) <= LAST_PORT:
        raise argparse.ArgumentTypeError(f"expected a port from 1 to {LAST_PORT}, got '{text}'")
    return int(text)


def add_clock(parser: argparse.ArgumentParser) -> None:
    """Add `--clock`, the effect of a reasoner's response time on the simulation."""
    parser.add_argument("--clock", default="lockstep", help="lockstep, latency:SECONDS or latency:measured")


PERCEPTIONS = ("privileged", "sensors")
"""Sources of perception: the simulator's ground truth, or the rig's sensors."""


def add_perception(parser: argparse.ArgumentParser) -> None:
    """Add `--perception`, the source of the surroundings for the driver and the solver."""
    parser.add_argument(
        "--perception",
        default=PERCEPTIONS[0],
        choices=PERCEPTIONS,
        help="source of perception: the simulator's ground truth, or camera, LiDAR, GNSS, IMU and wheel sensors",
    )


def add_map(parser: argparse.ArgumentParser, usual: str) -> None:
    """Add `--map` with this default, and `--maps`."""
    parser.add_argument("--map", default=usual, help="a town's name or an OpenDRIVE file")
    add_maps(parser)


def add_maps(parser: argparse.ArgumentParser) -> None:
    """Add `--maps`, the folders that are searched for towns."""
    parser.add_argument("--maps", help="folders to search for towns, separated by ':'")


def add_server(parser: argparse.ArgumentParser) -> None:
    """Add `--host` and `--port` of a running server that is used instead of a new carlette."""
    parser.add_argument("--host", help="use the CARLA server at this address instead of starting carlette")
    parser.add_argument("--port", type=port, default=2000, help="port of that server")


def add_json(parser: argparse.ArgumentParser, shape: str) -> None:
    """Add `--json`. `shape` describes the output; help and the command reference show it."""
    parser.add_argument("--json", action="store_true", help=f"print JSON: {shape}")


def print_json(data: object) -> None:
    """Print a result as JSON on standard output; paths become text."""
    print(json.dumps(data, indent=1, ensure_ascii=False, default=str))


def whole(text: str) -> int:
    """Parse a whole number. Raises `argparse.ArgumentTypeError`."""
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected a whole number, got '{text}'") from None


def at_least(least: int) -> Callable[[str], int]:
    """Return a parser of whole numbers from `least` on; it raises `argparse.ArgumentTypeError`."""

    def read(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = least - 1  # Rejected below.
        if value < least:
            raise argparse.ArgumentTypeError(f"expected a whole number from {least} on, got '{text}'")
        return value

    return read


def above_zero(text: str) -> float:
    """Parse a finite number above 0. Raises `argparse.ArgumentTypeError`."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0  # Rejected below.
    if not (math.isfinite(value) and value > 0.0):
        raise argparse.ArgumentTypeError(f"expected a number above 0, got '{text}'")
    return value
