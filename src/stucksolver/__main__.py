"""`python -m stucksolver`, for where the command is not installed."""

import sys

from stucksolver.cli import main

sys.exit(main())
