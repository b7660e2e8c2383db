"""`stucksolver serve-model`: the student behind OpenAI's chat completions API."""

from __future__ import annotations

import argparse
import socket
from pathlib import Path

from stucksolver.cli.arguments import whole
from stucksolver.cli.errors import UsageError

MISSING = "serve-model needs packages that are not installed: add the extra [distilled] (README, Install)"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.add_argument("--weights", type=Path, metavar="DIR", help="folder of the weights (default: those shipped)")
    parser.add_argument("--listen", default="127.0.0.1", metavar="ADDRESS", help="address to listen on")
    parser.add_argument("--port", type=whole, default=8000, help="port; 0 for any free one")


def run(options: argparse.Namespace) -> int:
    """Serve until Ctrl-C. Raises `UsageError` if the weights or the port cannot be used."""
    try:
        import uvicorn

        from stucksolver.serve.app import make_app
    except ImportError as error:
        raise UsageError(MISSING) from error
    from stucksolver.reason.distilled import DistilledReasoner, WeightsError
    from stucksolver.reason.distilled.network import DATA
    from stucksolver.serve.completions import MODEL, Student
    from stucksolver.words import find_reader

    try:
        student = Student(DistilledReasoner(options.weights or DATA), find_reader())
    except WeightsError as error:
        raise UsageError(str(error)) from error
    config = uvicorn.Config(make_app(student), log_level="warning")
    bound = _bound(options.listen, options.port)
    host, port = bound.getsockname()[:2]
    url = f"http://{f'[{host}]' if ':' in host else host}:{port}/v1"
    print(f"serving {MODEL} at {url}; use it as --recovery openai:{MODEL}@{url}", flush=True)
    uvicorn.Server(config).run(sockets=[bound])
    return 0


def _bound(address: str, port: int) -> socket.socket:
    """Return a socket bound to an address. Raises `UsageError` if it is taken."""
    try:
        return socket.create_server((address, port), family=socket.AF_INET6 if ":" in address else socket.AF_INET)
    except OSError as error:
        raise UsageError(f"cannot listen on {address}, port {port}: {error.strerror}; choose another --port") from error
