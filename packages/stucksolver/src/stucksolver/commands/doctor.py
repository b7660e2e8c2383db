"""`stucksolver doctor`: checks the installation, and reports missing parts with their remedy."""

from __future__ import annotations

import argparse
import importlib.util
import platform
import shutil
import socket
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Literal, TypeAlias

from stucksolver.commands.arguments import SUPPORTED, add_json, installed_version, print_json
from stucksolver.commands.errors import UsageError
from stucksolver.commands.terminal_text import filled
from stucksolver.plugins import PluginError, plugins

State = Literal["ok", "absent", "missing", "broken"]
"""State of a part: `absent` is optional and not installed; `missing` is required and not installed; `broken` fails."""
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "firefox")
FREE_MIB = 500
"""Least free space (MiB). A demonstration writes a few MiB; an evaluation of 220 routes writes a few hundred. Ours."""


@dataclass(frozen=True)
class Finding:
    """Result of one check. `needed`: True if the demonstration does not run without this part."""

    name: str
    state: State
    detail: str
    remedy: str = ""
    needed: bool = False


Check: TypeAlias = Callable[[], Iterator[Finding]]
"""Check of one part of the installation."""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add_json(parser, '[{"name", "state" (ok, absent, missing or broken), "detail", "remedy", "needed"}]')


def run(options: argparse.Namespace) -> int:
    """Print all findings. Returns 1 if a part that the demonstration needs is missing or broken, else 0."""
    results = list(findings())
    if options.json:
        print_json([asdict(item) for item in results])
    else:
        print("\n".join(_line(item) for item in results))
    return int(any(item.needed and item.state != "ok" for item in results))


def _line(finding: Finding) -> str:
    text = f"{finding.state:8}{finding.name}: {finding.detail}"
    return filled(f"{text}; {finding.remedy}" if finding.state != "ok" and finding.remedy else text)


def findings() -> Iterator[Finding]:
    """Run the core's checks and those of all plug-ins. A broken plug-in is a finding, and the other checks go on."""
    for check in CHECKS:
        yield from check()
    for plugin in plugins("checks"):
        try:
            checks: tuple[Check, ...] = plugin.load()
        except PluginError as error:
            yield Finding(plugin.distribution, "broken", str(error), "stucksolver plugins")
            continue
        for check in checks:
            yield from check()


def _python() -> Iterator[Finding]:
    platform_text = f"{platform.python_version()}, {platform.system()} {platform.machine()}"
    fits = (3, 10) <= sys.version_info[:2] <= (3, 12) and sys.platform == "linux" and platform.machine() == "x86_64"
    yield Finding("stucksolver", "ok", installed_version(), needed=True)
    yield Finding(
        "python",
        "ok" if fits else "broken",
        platform_text,
        f"the carla package exists for {SUPPORTED}",
        needed=True,
    )


def package(name: str, use: str, extra: str, *, needed: bool = False) -> Check:
    """Return a check for an installed package. `use` is its purpose, `extra` the extra that installs it."""

    def check() -> Iterator[Finding]:
        """Check whether the package is installed, and in which version."""
        remedy = f"add the extra [{extra}] (README, Install)"
        if importlib.util.find_spec(name) is None:
            yield Finding(name, "missing" if needed else "absent", use, remedy, needed)
            return
        try:
            installed = version(name)
        except PackageNotFoundError:
            installed = "of unknown version"  # A package without metadata is usable nevertheless.
        yield Finding(name, "ok", f"{installed}; {use}", needed=needed)

    return check


def _ports() -> Iterator[Finding]:
    """Check that ports can be opened: carlette and the passenger's page use ports that the system assigns."""
    try:
        with socket.socket() as first, socket.socket() as second:
            first.bind(("127.0.0.1", 0))
            second.bind(("127.0.0.1", 0))
            first.listen()
    except OSError as error:
        remedy = "allow programs to listen on the loopback address; in a container bring `lo` up"
        yield Finding("ports", "broken", f"no port on 127.0.0.1 can be opened: {error}", remedy, needed=True)
        return
    yield Finding("ports", "ok", "free ports on 127.0.0.1 can be opened", needed=True)


def _browser() -> Iterator[Finding]:
    """Find a browser, which shows reports and the passenger's page. It may also run on another machine."""
    browser = next((path for path in map(shutil.which, BROWSERS) if path), None)
    remedy = "apt install chromium, or copy the report to a machine with a browser; the browser tests need Chromium"
    yield Finding("browser", "ok" if browser else "absent", browser or f"none of {', '.join(BROWSERS)} on PATH", remedy)


def _settings() -> Iterator[Finding]:
    """Check the configuration file, if there is one."""
    from stucksolver.commands.config import all_settings
    from stucksolver.commands.settings import check_file, find_file, read_file

    try:
        file = find_file(None)
        if file is None:
            yield Finding(
                "configuration", "absent", "no file; every setting has its default", "stucksolver config init"
            )
            return
        check_file(file, read_file(file), all_settings())
    except UsageError as error:
        yield Finding(
            "configuration", "broken", str(error), "`stucksolver config init FILE` writes one to compare with"
        )
        return
    yield Finding("configuration", "ok", f"{file}; `stucksolver config show` prints its settings")


def _disk() -> Iterator[Finding]:
    free = shutil.disk_usage(Path.cwd()).free // 2**20
    state: State = "ok" if free >= FREE_MIB else "broken"
    yield Finding("disk", state, f"{free:,} MiB free here", "free some space, or choose another --out", needed=True)


CHECKS: tuple[Check, ...] = (_python, _ports, _browser, _settings, _disk)
