"""Results made up for tests are shown on pages here, too."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "results"))
