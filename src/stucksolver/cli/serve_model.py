"""`stucksolver serve-model`: the student behind OpenAI's chat completions API."""

from __future__ import annotations

import argparse
import asyncio
import sys
from pathlib import Path

from stucksolver.cli.arguments import whole
from stucksolver.cli.errors import UsageError

MISSING = "serve-model needs packages that are not installed: add the extra [distilled] (README, Install)"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.add_argument("--weights", type=Path, metavar="DIR", help="folder of the weights (default: those shipped)")
    parser.add_argument("--listen", default="127.0.0.1", metavar="ADDRESS", help="address to listen on")
    parser.add_argument("--port", type=whole, default=8000, help="port; 0 for any free one")
    parser.add_argument("--name", action="append", default=[], metavar="HOST", help="another name of this machine")


def run(options: argparse.Namespace) -> int:
    """Serve until Ctrl-C. Raises `UsageError` if the weights or the port cannot be used."""
    try:
        from stucksolver.passenger.server.serving import limits_here, make_server, serve
        from stucksolver.serve.app import PLACES, behind_doors, make_app
    except ImportError as error:
        raise UsageError(MISSING) from error
    from stucksolver.passenger import PageError, PageOptions
    from stucksolver.reason.distilled import DistilledReasoner, WeightsError
    from stucksolver.reason.distilled.network import DATA
    from stucksolver.serve.completions import MODEL, Student
    from stucksolver.words import find_reader

    try:
        student = Student(DistilledReasoner(options.weights or DATA), find_reader())
    except WeightsError as error:
        raise UsageError(str(error)) from error
    served = PageOptions(options.listen, options.port, names=tuple(options.name))
    try:
        served.check()
        bound = served.bound()
    except PageError as error:
        raise UsageError(f"{error}; choose another --listen or --port") from error
    addresses = served.addresses(bound.getsockname()[1])
    url = f"http://{addresses[0]}/v1"
    print(f"serving {MODEL} at {url}; use it as --recovery openai:{MODEL}@{url}", flush=True)
    if not served.is_local:
        print("warning: everybody who reaches this address may use the model; there is no key", file=sys.stderr)
    server = make_server(behind_doors(make_app(student), frozenset(addresses)), limits_here(PLACES))
    asyncio.run(serve(server, [bound]))
    return 0
