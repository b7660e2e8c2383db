"""Combines template, style, scripts and data into one self-contained page.

The data is untrusted, since signs and passengers' utterances may contain any text. It is embedded as JSON that cannot
contain markup, and the scripts insert it as text only. The page's content security policy permits only the two inline
blocks, by their digests.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

STYLES = ("palette.css", "report.css")
SCRIPTS = (
    "dom.js",
    "decode.js",
    "palette.js",
    "camera.js",
    "scene.js",
    "stage.js",
    "plot.js",
    "cards.js",
    "records.js",
    "table.js",
    "section.js",
    "main.js",
)
_ESCAPED = str.maketrans({"<": "\\u003c", ">": "\\u003e", "&": "\\u0026"})


def page(title: str, data: Mapping[str, Any]) -> str:
    """Return the HTML page."""
    style = "".join(_asset(name) for name in STYLES)
    script = '"use strict";\n(() => {\n' + "\n".join(_asset(name) for name in SCRIPTS) + "\n})();\n"
    parts = {
        "TITLE": html.escape(title).encode("ascii", "xmlcharrefreplace").decode(),
        "STYLE": style,
        "STYLE_DIGEST": block_digest(style),
        "SCRIPT": script,
        "SCRIPT_DIGEST": block_digest(script),
        "DATA": embedded_json(data),
    }
    # One pass replaces all marks, so that inserted text is never searched for further marks.
    return re.sub(r"\{\{([A-Z_]+)\}\}", lambda mark: parts[mark[1]], _asset("report.html"))


def embedded_json(data: object) -> str:
    """Return JSON that is safe inside a script element: ASCII only, without `<`, `>` and `&`."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False).translate(_ESCAPED)


def _asset(name: str) -> str:
    return (files(__package__) / "assets" / name).read_text(encoding="utf-8")


def block_digest(text: str) -> str:
    """Return the digest by which a content security policy permits an inline block."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
