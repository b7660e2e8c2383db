"""`python -m lab`: trains and scores the networks."""

from __future__ import annotations

import sys

from lab.commands import COMMANDS
from stucksolver.commands.main import main

if __name__ == "__main__":
    sys.exit(main(program="python -m lab", table=COMMANDS))
