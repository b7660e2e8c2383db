"""`stucksolver ride`: drives along a street with a passenger on a web page."""

from __future__ import annotations

import argparse
import contextlib
import ipaddress
import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from stucksolver.commands.arguments import add_maps, add_server, port, whole
from stucksolver.commands.errors import UsageError
from stucksolver_eval.commands.run_arguments import driver_name
from stucksolver_passenger.commands.memory import add_memory

if TYPE_CHECKING:
    from stucksolver_passenger.server.process import PassengerServer

CASES = ("parked_car", "cyclists", "pedestrians", "open_door")
MISSING = "the packages for the page are not installed: add the extra [passenger] (README, Install)"
OPEN = "note: the traffic is not encrypted, and anyone on this network can read it; see --cert and --key"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.add_argument("--case", choices=CASES, default="parked_car", help="the situation on the route")
    parser.add_argument("--map", help="a town's name or an OpenDRIVE file (default: one that suits the case)")
    add_maps(parser)
    parser.add_argument("--seed", type=whole, default=1, help="seed of positions and traffic")
    parser.add_argument(
        "--driver", default="behavior", help="behavior or planner, each with :cautious|normal|aggressive"
    )
    parser.add_argument(
        "--ladder", type=Path, metavar="FILE", help="escalation policy; replaces the built-in one and --no-ask"
    )
    parser.add_argument("--no-ask", action="store_true", help="use the oncoming lane without asking the passenger")
    parser.add_argument(
        "--once", action="store_true", help="end at the destination; otherwise the page stays open until Ctrl-C"
    )
    add_page(parser)
    add_memory(parser)
    add_server(parser)


def add_page(parser: argparse.ArgumentParser) -> None:
    """Add the options of the passenger's page, which several commands share."""
    parser.add_argument("--listen", metavar="ADDRESS", help="let other devices reach the page at this address")
    parser.add_argument("--page-port", type=port, metavar="PORT", help="port of the page (default: any free port)")
    parser.add_argument("--page-name", action="append", default=[], metavar="HOST", help="another name of this machine")
    parser.add_argument("--cert", type=Path, metavar="PEM", help="serve the page over HTTPS with this certificate")
    parser.add_argument("--key", type=Path, metavar="PEM", help="private key of that certificate")


def run(options: argparse.Namespace) -> int:
    """Drive until the car arrives. Returns 0. Raises `UsageError`."""
    from stucksolver.ladder import LadderError
    from stucksolver_carla.client_connection import ServerError
    from stucksolver_carla.drivers.behavior import RouteError
    from stucksolver_eval.cases.case import CaseError
    from stucksolver_eval.drivers.factory import DriverNameError, check_driver
    from stucksolver_eval.ride import RideSpec, drive_ride, find_ride
    from stucksolver_eval.ride.ride import VEHICLE, RideError
    from stucksolver_eval.scenarios.scenario import ScenarioError, UnsupportedScenarioError
    from stucksolver_eval.streets.finder import StreetError
    from stucksolver_passenger.gateway import PassengerGateway
    from stucksolver_passenger.link import LinkError
    from stucksolver_passenger.memory import MemoryFileError, SolutionStore

    spec = RideSpec(
        case=options.case,
        map_name=options.map,
        maps=options.maps,
        seed=options.seed,
        driver=driver_name(options.driver),
        ladder=options.ladder,
        asks=not options.no_ask,
        memory=options.memory,
        host=options.host,
        port=options.port,
    )
    try:
        spec.policy()
        if spec.memory is not None:
            SolutionStore(spec.memory)
        check_driver(spec.driver)
        page = page_server(options)
        route = find_ride(spec)
        with page as server, PassengerGateway(server.address) as desk:
            outcome = drive_ride(spec, route, desk, begun=lambda: print_page_url(server, VEHICLE, options.listen))
            print(f"{'arrived' if outcome.arrived else 'ended'} after {outcome.duration_s:.0f} s; {_pace(outcome)}")
            if not options.once:
                print("the page stays open until Ctrl-C", flush=True)
                # Ctrl-C is the way to close the page.
                with contextlib.suppress(KeyboardInterrupt):
                    threading.Event().wait()
    except (
        CaseError,
        DriverNameError,
        LadderError,
        LinkError,
        MemoryFileError,
        RideError,
        RouteError,
        ScenarioError,
        ServerError,
        StreetError,
        UnsupportedScenarioError,
    ) as error:
        raise UsageError(str(error)) from error
    return 0


def page_server(options: argparse.Namespace) -> PassengerServer:
    """Return the server of the page, not yet started. Raises `UsageError`."""
    try:
        import fastapi  # noqa: F401
        import uvicorn  # noqa: F401
    except ImportError as error:
        raise UsageError(MISSING) from error
    from stucksolver.interpreter import NoInterpreter, find_reader
    from stucksolver_eval.report import ASSETS
    from stucksolver_passenger.server.options import PageOptions, ServerOptionsError
    from stucksolver_passenger.server.process import PassengerServer
    from stucksolver_passenger.speech_recognizer import find_recognizer

    reader = find_reader()
    if isinstance(reader, NoInterpreter):
        raise UsageError(reader.why)
    page = PageOptions(
        listen=options.listen or PageOptions.listen,
        port=options.page_port or 0,
        cert=options.cert,
        key=options.key,
        names=tuple(options.page_name),
        drawing=ASSETS,
        recognizer=find_recognizer(),
    )
    try:
        page.check()
        page.bound().close()
        return PassengerServer(page)
    except ServerOptionsError as error:
        raise UsageError(str(error)) from error


def print_page_url(server: PassengerServer, vehicle: str, listen: str | None, out: TextIO | None = None) -> None:
    """Print the page's addresses to `out` (standard output), and a QR code if a phone can reach the page."""
    url = server.url(server.tokens.passenger(vehicle))
    print(f"passenger: {url}\noperator:  {server.url(server.tokens.operator())}", file=out, flush=True)
    if listen is None or ipaddress.ip_address(listen).is_loopback:
        return
    if server.options.cert is None:
        print(OPEN, file=sys.stderr)
    try:
        import segno
    except ImportError:
        # Without the package for QR codes, the printed address suffices.
        return
    segno.make(url, error="l").terminal(out=out, compact=True)


def _pace(outcome: object) -> str:
    ticks, late = getattr(outcome, "ticks", 0), getattr(outcome, "late", 0)
    worst_ms = 1000.0 * getattr(outcome, "worst_s", 0.0)
    return f"{ticks} ticks, {late} late, at most {worst_ms:.0f} ms behind"
