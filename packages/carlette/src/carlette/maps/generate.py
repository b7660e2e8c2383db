"""Writes the shipped maps.

```sh
python -m carlette.maps.generate           # writes all maps
python -m carlette.maps.generate --check   # fails if a committed file differs
```

The demo town needs the extra `maps`; the others need no extra.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

from carlette.maps import SHIPPED
from carlette.maps.build import map_xml
from carlette.maps.layouts import grid_town, interurban, motorway


def demo_town() -> str:
    """Return the demo town's text."""
    from carlette.maps.layouts.demo_town import town_xml

    return town_xml()


WRITERS: Mapping[str, Callable[[], str]] = {
    "demo_town": demo_town,
    "grid_town": lambda: map_xml(grid_town.plan()),
    "interurban": lambda: map_xml(interurban.plan()),
    "motorway": lambda: map_xml(motorway.plan()),
}
"""The function that makes each map's text, by the map's name."""


def main(arguments: list[str] | None = None, folder: Path = SHIPPED) -> int:
    """Run the script. Returns 1 if `--check` finds a difference."""
    parser = argparse.ArgumentParser(prog="python -m carlette.maps.generate", description="Writes the shipped maps.")
    parser.add_argument("--check", action="store_true", help="compare, do not write")
    check = parser.parse_args(arguments).check
    differing = []
    for name, write in WRITERS.items():
        path, text = folder / f"{name}.xodr", write()
        if not check:
            path.write_text(text, encoding="utf-8", newline="\n")
        elif not path.exists() or path.read_bytes() != text.encode():
            differing.append(path.name)
    for changed in differing:
        print(f"{changed} differs. Run `python -m carlette.maps.generate`", file=sys.stderr)
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
