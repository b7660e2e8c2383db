"""Builds the site: `python -m lab.docsite [--out DIR] [--report out/demo/report.html]`; a broken link is an error."""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from lab.docsite.diagrams import ROOT, picture, sources
from lab.docsite.stage import stage

MENDED = (
    # The theme's search dialog has no accessible name.
    (
        re.compile('data-md-component="search" role="dialog"'),
        'data-md-component="search" role="dialog" aria-label="Search"',
    ),
    # Markdown turns the empty corner of a table into a header cell.
    (re.compile(r"<th(?: style=\"[^\"]*\")?></th>"), "<td></td>"),
)
"""Replacements made in every page."""


SOURCES = sorted(ROOT.glob("packages/*/src"))
"""Packages whose docstrings the reference shows."""


def main() -> int:
    """Stage and build the site; return 1 if a page has a broken link or does not build."""
    parser = argparse.ArgumentParser(prog="python -m lab.docsite", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/site"), help="output folder")
    parser.add_argument("--report", type=Path, help="page of a demonstration, included unchanged")
    options = parser.parse_args()
    if options.report and not options.report.is_file():
        parser.error(f"file not found: {options.report}. `make demo` writes out/demo/report.html")
    undrawn = [source for source in sources() if not picture(source).is_file()]
    if undrawn:
        print(
            f"note: {len(undrawn)} diagrams are shown as text; python -m lab.docsite.diagrams draws them",
            file=sys.stderr,
        )
    with tempfile.TemporaryDirectory() as folder:
        pages = Path(folder) / "pages"
        stage(pages, options.report)
        config = Path(folder) / "mkdocs.yml"
        text = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").replace("[SRC]", f"[{', '.join(map(str, SOURCES))}]")
        config.write_text(f"{text}\ndocs_dir: {pages}\nsite_dir: {options.out.resolve()}\n", encoding="utf-8")
        command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--config-file", str(config)]
        done = subprocess.run(
            command,
            cwd=ROOT,
            env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if not line.startswith("INFO")]
        print("\n".join(lines), file=sys.stderr)
        return 1
    for page in options.out.rglob("*.html"):
        if page.name == "report.html":
            continue  # the replay is included unchanged
        text = page.read_text(encoding="utf-8")
        for wrong, right in MENDED:
            text = wrong.sub(right, text)
        page.write_text(text, encoding="utf-8")
    print(f"site: {options.out / 'index.html'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
