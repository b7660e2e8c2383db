"""HTML for pages without scripts: page frame, tables and notes. All inserted text is escaped here."""

from __future__ import annotations

import html
import re
from collections.abc import Sequence
from importlib.resources import files
from urllib.parse import quote

from stucksolver_eval.report.page import block_digest

WIDTH = 100
HEIGHT = 10


def bar_cell(value: float | None, digits: int = 1) -> str:
    """Return a table cell with a number from 0 to 100 and its bar. None means that there is no number."""
    if value is None:
        return '<td class="figure">no route</td>'
    length = WIDTH * min(max(value, 0.0), 100.0) / 100.0
    bar = f'<rect class="rail" width="{WIDTH}" height="{HEIGHT}"/><rect width="{length:.1f}" height="{HEIGHT}"/>'
    drawn = f'<svg class="bar" viewBox="0 0 {WIDTH} {HEIGHT}" aria-hidden="true">{bar}</svg>'
    return f'<td class="figure">{value:.{digits}f} {drawn}</td>'


STYLES = ("palette.css", "tables.css")


def document(title: str, head: Sequence[str], sections: Sequence[str]) -> str:
    """Return a page. `head` goes below its title, `sections` (see `section`) into its main part."""
    style = "".join((files(__package__) / "assets" / name).read_text(encoding="utf-8") for name in STYLES)
    policy = f"default-src 'none'; style-src '{block_digest(style)}'; base-uri 'none'; form-action 'none'"
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        '<meta name="color-scheme" content="light dark"><meta name="referrer" content="no-referrer">'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
        f"<title>{text(title)}</title><style>{style}</style></head><body>\n"
        f"<header><h1>{text(title)}</h1>\n" + "\n".join(head) + "</header>\n"
        "<main>\n" + "\n".join(sections) + "\n</main></body></html>\n"
    )


def text(words: str) -> str:
    """Escape text for HTML and attribute values; a lone surrogate becomes a question mark."""
    return html.escape(words).encode("utf-8", "replace").decode()


def section(name: str, *parts: str) -> str:
    """Return a section with its own heading."""
    # The names come from the run, so they may contain any character.
    anchor = "-".join(re.findall(r"[a-z0-9]+", name.lower())) or "section"
    body = "\n".join(part for part in parts if part)
    return f'<section aria-labelledby="{anchor}"><h2 id="{anchor}">{text(name)}</h2>\n{body}</section>'


def code(words: str) -> str:
    """Return a command or path as inline code."""
    return f"<code>{text(words)}</code>"


def note(words: str) -> str:
    """Return an explanatory paragraph."""
    return f'<p class="note">{text(words)}</p>' if words else ""


def warning(words: str) -> str:
    """Return a highlighted paragraph."""
    return f'<p class="warning">{text(words)}</p>'


def cell(words: str) -> str:
    """Return a table cell. Numbers are right-aligned."""
    figure = bool(words) and (words[0].isdigit() or words[0] in "–+-") and len(words.split()) <= 2
    return f'<td class="figure">{text(words)}</td>' if figure else f"<td>{text(words)}</td>"


def table(name: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table of text that scrolls sideways; the first cell of each row is its header."""
    return raw_table(name, head, [[text(row[0]), *(cell(words) for words in row[1:])] for row in rows])


def raw_table(name: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table from HTML cells. Only the first cell of each row gets its `<th>` here."""
    columns = "".join(f'<th scope="col">{text(words)}</th>' for words in head)
    lines = "\n".join(f'<tr><th scope="row">{row[0]}</th>{"".join(row[1:])}</tr>' for row in rows)
    return (
        f'<div class="scroll" tabindex="0" role="region" aria-label="{text(name)}: table"><table>'
        f"<thead><tr>{columns}</tr></thead>\n<tbody>{lines}</tbody></table></div>"
    )


def link(target: str, words: str) -> str:
    """Return a link to `target`, a path relative to the page's folder. It is never an address with a scheme."""
    return f'<a href="{text(quote(target, safe="/", errors="surrogateescape"))}">{text(words)}</a>'
