"""`stucksolver doctor`: checks what is installed, what is missing, and how to get it."""

from __future__ import annotations

import argparse
import importlib.util
import os
import platform
import shutil
import socket
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Literal

from stucksolver.cli.arguments import SUPPORTED, add_json, installed_version, print_json
from stucksolver.cli.errors import UsageError
from stucksolver_eval.terminal import filled

State = Literal["ok", "absent", "missing", "broken"]
"""`absent` is optional and not installed; `missing` is required and not installed; `broken` does not work."""
CARLA_PORT = 2000
ANSWERS_S = 20.0
PERCEPTION = ("numpy", "onnxruntime", "PIL", "scipy", "filterpy")
SERVER_ANSWERS_S = 3.0
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "firefox")
FREE_MIB = 500
"""A demonstration writes a few MiB; an evaluation of 220 routes writes a few hundred."""


@dataclass(frozen=True)
class Finding:
    """The result of one check. `needed`: the demonstration does not run without it."""

    name: str
    state: State
    detail: str
    remedy: str = ""
    needed: bool = False


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add_json(parser, '[{"name", "state" (ok, absent, missing or broken), "detail", "remedy", "needed"}]')


def run(options: argparse.Namespace) -> int:
    """Print all findings. Returns 1 if something that the demonstration needs is missing or broken, else 0."""
    found = list(findings())
    if options.json:
        print_json([asdict(one) for one in found])
    else:
        print("\n".join(_line(one) for one in found))
    return int(any(one.needed and one.state != "ok" for one in found))


def _line(one: Finding) -> str:
    text = f"{one.state:8}{one.name}: {one.detail}"
    return filled(f"{text}; {one.remedy}" if one.state != "ok" and one.remedy else text)


def findings() -> Iterator[Finding]:
    """Run all checks, in the order in which a newcomer needs the results."""
    for look in LOOKS:
        yield from look()


def _python() -> Iterator[Finding]:
    told = f"{platform.python_version()}, {platform.system()} {platform.machine()}"
    fits = (3, 10) <= sys.version_info[:2] <= (3, 12) and sys.platform == "linux" and platform.machine() == "x86_64"
    yield Finding("stucksolver", "ok", installed_version(), needed=True)
    yield Finding(
        "python",
        "ok" if fits else "broken",
        told,
        f"the carla package exists for {SUPPORTED}",
        needed=True,
    )


def _package(name: str, use: str, extra: str, *, needed: bool = False) -> Callable[[], Iterator[Finding]]:
    """Return a check for an installed package. `use` says what it is for, `extra` which extra installs it."""

    def look() -> Iterator[Finding]:
        """Check whether it is installed, and in which version."""
        remedy = f"add the extra [{extra}] (README, Install)"
        if importlib.util.find_spec(name) is None:
            yield Finding(name, "missing" if needed else "absent", use, remedy, needed)
            return
        try:
            told = version(name)
        except PackageNotFoundError:
            told = "of unknown version"
        yield Finding(name, "ok", f"{told}; {use}", needed=needed)

    return look


def _simulator() -> Iterator[Finding]:
    """Start the simulator and query it: the client's library may be installed and still fail to load."""
    if importlib.util.find_spec("carla") is None:
        return
    try:
        from stucksolver_eval.server import carlette_server, connect

        with carlette_server("demo_town") as server:
            town = connect(server, ANSWERS_S).get_world().get_map().name
    except Exception as error:  # noqa: BLE001 - report whatever the foreign library raises
        why = str(error).splitlines()[0] if str(error) else type(error).__name__
        yield Finding("carlette", "broken", why, "install carlette again (README, Install)", needed=True)
        return
    yield Finding("carlette", "ok", f"the embedded simulator started and answered with {town}", needed=True)


def _words() -> Iterator[Finding]:
    from stucksolver.words import NoReader, find_reader

    reader = find_reader()
    if isinstance(reader, NoReader):
        yield Finding("reader of words", "absent", reader.why.split(";")[0], "add the extra [words] (README, Install)")
        return
    try:
        reading = reader.read("please go round it", "")
    except RuntimeError as error:
        yield Finding("reader of words", "broken", str(error), "install stucksolver again")
        return
    yield Finding("reader of words", "ok", f'{reader.name}; "please go round it" is read as {reading.told}')


def _student() -> Iterator[Finding]:
    from stucksolver.reason.distilled import DistilledReasoner, WeightsError

    what = "student"
    if importlib.util.find_spec("onnxruntime") is None:
        yield Finding(what, "absent", "onnxruntime is not installed", "add the extra [distilled] (README, Install)")
        return
    try:
        yield Finding(what, "ok", f"{DistilledReasoner().name} loads")
    except WeightsError as error:
        yield Finding(what, "broken", str(error), "install stucksolver again")


def _perception() -> Iterator[Finding]:
    what = "perception by sensors"
    missing = [name for name in PERCEPTION if importlib.util.find_spec(name) is None]
    if missing:
        yield Finding(
            what, "absent", f"{', '.join(missing)} not installed", "add the extra [perception] (README, Install)"
        )
        return
    from stucksolver.perception.perceiver import why_not_here

    why = why_not_here()
    yield Finding(what, "broken" if why else "ok", why or "three networks and the rig load")


def _signs() -> Iterator[Finding]:
    from stucksolver.perception.camera.sign_reader import PACKAGE, why_not_read

    found = why_not_read() is None
    remedy = "" if found else "add the extra [signs] (README, Install)"
    yield Finding(
        "words on signs", "ok" if found else "absent", f"{PACKAGE} {'' if found else 'not '}installed", remedy
    )


def _model() -> Iterator[Finding]:
    from stucksolver.privacy.addresses import shown
    from stucksolver.reason.llm.keys import KEY_VARIABLE
    from stucksolver.reason.llm.openai_api import URL_VARIABLE

    key, base = os.environ.get(KEY_VARIABLE), os.environ.get(URL_VARIABLE)
    if key or base:
        yield Finding(
            "language model", "ok", f"{KEY_VARIABLE} is set" if key else f"{URL_VARIABLE} is {shown(base or '')}"
        )
        return
    remedy = f"set {KEY_VARIABLE}, or name a server of your own: --reasoner openai:MODEL@http://HOST:PORT/v1"
    yield Finding("language model", "absent", "no key and no server; the rules need none", remedy)


def _maps() -> Iterator[Finding]:
    told = os.environ.get("STUCKSOLVER_MAPS", "")
    folders = [Path(folder) for folder in told.split(":") if folder]
    towns = sorted({path.stem for folder in folders for path in folder.glob("*.xodr")})
    gone = [str(folder) for folder in folders if not folder.is_dir()]
    if gone:
        yield Finding("maps", "broken", f"STUCKSOLVER_MAPS: no such folder: {', '.join(gone)}", "correct the variable")
    elif towns:
        yield Finding("maps", "ok", f"{len(towns)} towns besides the shipped ones: {', '.join(towns)}")
    else:
        remedy = "for CARLA's towns set STUCKSOLVER_MAPS to the folder with their .xodr files"
        yield Finding("maps", "absent", "the shipped towns only", remedy)


def _agents() -> Iterator[Finding]:
    told = os.environ.get("CARLA_AGENTS", "")
    found = importlib.util.find_spec("agents") is not None or (told and Path(told, "agents").is_dir())
    remedy = "set CARLA_AGENTS to PythonAPI/carla of a CARLA installation; only `attach` and Bench2Drive need it"
    yield Finding("CARLA's agents", "ok" if found else "absent", told or "the package `agents`", remedy)


def _server() -> Iterator[Finding]:
    """Look for a server for `--host`. Whatever listens is queried, because it may be another program."""
    name, where = "CARLA server", f"127.0.0.1:{CARLA_PORT}"
    if not _listens(CARLA_PORT):
        remedy = "only `--host` needs one; the commands start carlette by themselves"
        yield Finding(name, "absent", f"nothing listens on {where}", remedy)
        return
    if importlib.util.find_spec("carla") is None:
        yield Finding(
            name, "ok", f"something listens on {where}; it was not queried, since the carla package is missing"
        )
        return
    import carla

    client = carla.Client("127.0.0.1", CARLA_PORT)
    client.set_timeout(SERVER_ANSWERS_S)
    try:
        yield Finding(name, "ok", f"version {client.get_server_version()} answers on {where}")
    except RuntimeError:
        remedy = "start CARLA on another port and name it by --port, or stop that program"
        yield Finding(name, "broken", f"the program that listens on {where} does not answer like CARLA", remedy)


def _listens(port: int) -> bool:
    with socket.socket() as probe:
        probe.settimeout(0.5)
        return probe.connect_ex(("127.0.0.1", port)) == 0


def _ports() -> Iterator[Finding]:
    """Check that ports can be opened: carlette and the passenger's page use ports that the system assigns."""
    try:
        with socket.socket() as one, socket.socket() as two:
            one.bind(("127.0.0.1", 0))
            two.bind(("127.0.0.1", 0))
            one.listen()
    except OSError as error:
        remedy = "allow programs to listen on the loopback address; in a container bring `lo` up"
        yield Finding("ports", "broken", f"no port on 127.0.0.1 can be opened: {error}", remedy, needed=True)
        return
    yield Finding("ports", "ok", "free ports on 127.0.0.1 can be opened", needed=True)


def _browser() -> Iterator[Finding]:
    """Look for a browser, which shows reports and the passenger's page; it may also run on another machine."""
    found = next((path for path in map(shutil.which, BROWSERS) if path), None)
    remedy = "apt install chromium, or copy the report to a machine with a browser; the browser tests need Chromium"
    yield Finding("browser", "ok" if found else "absent", found or f"none of {', '.join(BROWSERS)} on PATH", remedy)


def _settings() -> Iterator[Finding]:
    """Check the configuration file, if there is one."""
    from stucksolver.cli.config import all_settings
    from stucksolver.cli.settings import check_file, find_file, read_file

    try:
        file = find_file(None)
        if file is None:
            yield Finding(
                "configuration", "absent", "no file; every setting is at its default", "stucksolver config init"
            )
            return
        check_file(file, read_file(file), all_settings())
    except UsageError as error:
        yield Finding(
            "configuration", "broken", str(error), "`stucksolver config init FILE` writes one to compare with"
        )
        return
    yield Finding("configuration", "ok", f"{file}; `stucksolver config show` prints what it sets")


def _disk() -> Iterator[Finding]:
    free = shutil.disk_usage(Path.cwd()).free // 2**20
    state: State = "ok" if free >= FREE_MIB else "broken"
    yield Finding("disk", state, f"{free:,} MiB free here", "free some space, or choose another --out", needed=True)


LOOKS: tuple[Callable[[], Iterator[Finding]], ...] = (
    _python,
    _package("carla", "the client of CARLA and carlette", "sim", needed=True),
    _simulator,
    _words,
    _student,
    _package("openai", "language models over HTTP", "llm"),
    _model,
    _perception,
    _signs,
    _package("fastapi", "the passenger's page", "passenger"),
    _package("matplotlib", "plots of evaluations", "report"),
    _package("distributed", "evaluations on a cluster", "cluster"),
    _maps,
    _agents,
    _server,
    _ports,
    _browser,
    _settings,
    _disk,
)
