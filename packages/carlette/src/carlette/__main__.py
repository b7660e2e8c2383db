"""`python -m carlette`."""

import sys

from carlette.cli import main

sys.exit(main())
