"""Collects the sources of the site: the repository's pages, and pages generated from the code.

Pages keep their paths in the repository, so that links between them work in both places.
"""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

from lab.docsite.diagrams import ROOT, with_images
from lab.docsite.generate import commands_page, http_page, openapi, schema_files, schemas_page, settings_page

PAGES = ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md")
LINK = re.compile(r"(?<!!)\[([^\]\n]+)\]\(([^)\s#]+)(#[^)\s]*)?\)")
PICTURE_TYPES = (".png", ".svg", ".jpg", ".webp")
FILE_MAX_BYTES = 300_000
"""Size up to which a linked file is copied (bytes). Ours; a larger one is only named."""


def stage(target: Path, report: Path | None = None) -> None:
    """Fill an empty folder. `report`: the page of a demonstration, included in the site unchanged."""
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    for source in _pages():
        _put(target / source.relative_to(ROOT), source)
    for folder in ("docs", "results"):
        for source in (ROOT / folder).rglob("*"):
            if source.suffix in PICTURE_TYPES:
                _copy(source, target)
    for name in ("site.css", "site.js"):
        _copy(ROOT / "docs" / name, target)
    reference = target / "docs" / "reference"
    made = {"commands.md": commands_page(), "configuration.md": settings_page(), "schemas.md": schemas_page()}
    made |= {"http.md": http_page(), "openapi.json": json.dumps(openapi(), indent=1)}
    for name, text in made.items():
        _write(reference / name, text)
    for name, text in schema_files().items():
        _write(reference / "schemas" / name, text)
    _write(target / "docs" / "demo.md", _demo_page(report is not None))
    if report is not None:
        (target / "docs" / "demo").mkdir()
        shutil.copy(report, target / "docs" / "demo" / "report.html")


def _pages() -> list[Path]:
    found = [ROOT / name for name in PAGES]
    return [*found, *(ROOT / "docs").rglob("*.md"), *(ROOT / "results").glob("*.md")]


def _put(place: Path, source: Path) -> None:
    up = "../" * len(source.relative_to(ROOT).parts[:-1])
    text = with_images(source.read_text(encoding="utf-8"), up)
    _write(place, LINK.sub(lambda found: _link(found, source, place), text))


def _link(found: re.Match[str], source: Path, place: Path) -> str:
    """Return the link of a page.

    A link to another page stays. For a link to another file, the file is copied, or only named.
    """
    words, to = found[1], found[2]
    target = (source.parent / to).resolve()
    if "://" in to or to.startswith("mailto:") or not target.is_relative_to(ROOT) or not target.exists():
        return found[0]
    if target in _pages() or target.suffix in PICTURE_TYPES or "reference" in target.parts:
        return found[0]
    if target.is_file() and target.stat().st_size <= FILE_MAX_BYTES:
        _copy(target, place.parents[len(source.relative_to(ROOT).parts) - 1])
        return found[0]
    return words if words.startswith("`") else f"{words} (`{target.relative_to(ROOT)}`)"


def _copy(source: Path, target: Path) -> None:
    place = target / source.relative_to(ROOT)
    place.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(source, place)


def _write(place: Path, text: str) -> None:
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_text(text, encoding="utf-8")


def _demo_page(there: bool) -> str:
    where = (
        "[**Open the replay**](demo/report.html){ .md-button }"
        if there
        else "This build does not include the replay; create it with `make demo`."
    )
    return f"""\
# Demo

Four runs in a street of a generated town, each replayed from above with every decision at the moment it was made: the
driver alone behind a parked car, StuckSolver there, two slow cyclists ahead, and a passenger who asks to overtake them.
`make demo` writes this replay as a single page that loads nothing else.

{where}

![The same street twice: the driver alone stays behind a parked car; with StuckSolver it goes round](images/demo.webp)
"""
