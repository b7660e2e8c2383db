"""`python -m stucksolver`, for where the command is not installed."""

import sys

from stucksolver.commands import main

sys.exit(main())
