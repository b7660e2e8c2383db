"""The commands, and where each of them is: only the one that is called is imported, so that help comes at once."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from importlib import import_module


@dataclass(frozen=True)
class Command:
    """`module` holds `add_options(parser)`, or that name with a prefix, and the function that runs it."""

    about: str
    module: str
    options: str = "add_options"
    run: str = "run"
    drives: bool = False
    """Does it need CARLA's client package?"""
    more: str = ""
    """What its own help says, where that is more."""

    def fill(self, parser: argparse.ArgumentParser) -> None:
        """Import the command, and give the parser its options."""
        module = import_module(f"stucksolver.cli.{self.module}")
        getattr(module, self.options)(parser)
        parser.set_defaults(run=getattr(module, self.run), drives=self.drives)


COMMANDS = {
    "demo": Command("drive past a parked car and two cyclists, without and with help, and report", "demo", drives=True),
    "ride": Command("ride along a street with a page to talk to the car", "ride", drives=True),
    "evaluate": Command("drive a suite of routes with scenarios, and score it", "evaluate", drives=True),
    "score": Command("compute all scores of evaluations from their files", "score"),
    "compare": Command(
        "is the second evaluation better than the first, and how surely?",
        "score",
        "add_compare_options",
        "run_compare",
        more="Is the second evaluation better than the first, and how surely? Prints driving score, success rate and "
        "route completion of both, the difference B - A over the routes and seeds that both drove, with its 95 % "
        "interval and p-value, what their recoveries did, and the routes that B won and lost. With several B each is "
        "compared with A.",
    ),
    "watch": Command(
        "observe a running car in CARLA or carlette: detect, reason, check and record, never act", "watch", drives=True
    ),
    "replay": Command("derive every decision and verdict of a record again, offline", "replay"),
    "ladder": Command("print a ladder that ships, to start from, or check one of your own", "ladder"),
    "prompt": Command("show what a model would be sent for a scene", "prompt"),
    "words": Command("read a passenger's words: lines of situation and text in, readings out", "read_words"),
    "cases": Command(
        "run the three cases of Bao and Li 2025 with a reasoner, and draw what it saw", "cases", drives=True
    ),
    "memory": Command("list, show, export or delete what is remembered of earlier drives", "memory"),
    "perception": Command("record drives, train perception on them, and score it", "perception"),
    "voice": Command("install a speech recognizer for the passenger's page, which runs in the browser", "voice"),
    "doctor": Command("say what is installed here, what is missing, and how to get it", "doctor"),
    "config": Command("show the settings of file and environment, or write a file to start from", "config"),
    "completion": Command("print what makes a shell complete commands and options", "completion"),
}
