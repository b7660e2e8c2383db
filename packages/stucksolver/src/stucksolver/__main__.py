"""Runs `python -m stucksolver`, for an environment without the command."""

import sys

from stucksolver.commands import main

sys.exit(main())
