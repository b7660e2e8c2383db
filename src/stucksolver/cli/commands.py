"""The list of commands. Only the command that is called is imported, so that `--help` is fast."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from importlib import import_module


@dataclass(frozen=True)
class Command:
    """One command. `options` and `run` name the functions of `module` that add its options and run it."""

    about: str
    module: str
    options: str = "add_options"
    run: str = "run"
    drives: bool = False
    """True if it needs CARLA's client package."""
    more: str = ""
    """A longer description for the command's own help."""

    def fill(self, parser: argparse.ArgumentParser) -> None:
        """Import the command and add its options to the parser."""
        module = import_module(f"stucksolver.cli.{self.module}")
        getattr(module, self.options)(parser)
        parser.set_defaults(run=getattr(module, self.run), drives=self.drives)


COMMANDS = {
    "demo": Command("drive past a parked car and two cyclists, without and with help, and report", "demo", drives=True),
    "ride": Command("ride along a street with a page to talk to the car", "ride", drives=True),
    "evaluate": Command("drive a suite of routes with scenarios, and score it", "evaluate", drives=True),
    "score": Command("compute all scores of evaluations from their files", "score"),
    "compare": Command(
        "test whether one evaluation is better than another",
        "score",
        "add_compare_options",
        "run_compare",
        more="Tests whether evaluation B is better than A. Prints driving score, success rate and route completion of "
        "both, the difference B - A over the routes and seeds that both drove, with its 95 % interval and p-value, "
        "what their recoveries did, and the routes that B won and lost. Each of several Bs is compared with A.",
    ),
    "watch": Command(
        "observe a car in a running simulator: detect, reason, check and record, but never act", "watch", drives=True
    ),
    "replay": Command("recompute every decision and verdict of a record offline, and compare", "replay"),
    "ladder": Command("print a shipped ladder as a starting point, or check your own", "ladder"),
    "prompt": Command("show what would be sent to a language model for a scene", "prompt"),
    "words": Command("interpret passengers' words: JSON lines of situation and text in, readings out", "read_words"),
    "cases": Command("run the cases of Bao and Li 2025 with a reasoner, and draw them", "cases", drives=True),
    "memory": Command("list, show, export or delete what is remembered of earlier drives", "memory"),
    "perception": Command("record drives, train perception on them, and score it", "perception"),
    "distill": Command("collect what the student learns from, train it, score it and export it", "distill"),
    "serve-model": Command("serve the student as a model with OpenAI's chat completions API", "serve_model"),
    "voice": Command("install a speech recognizer for the passenger's page, which runs in the browser", "voice"),
    "doctor": Command("check what is installed, what is missing, and how to get it", "doctor"),
    "config": Command("show the settings in effect, or write a configuration file to start from", "config"),
    "completion": Command("print a script that makes a shell complete commands and options", "completion"),
}
