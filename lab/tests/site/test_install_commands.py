"""No page and no message tells anyone to install from the package index what we have not published there.

Whoever registers such a name first would have their code run by everybody who follows the page.
"""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
OURS = {path.name for path in (ROOT / "packages").iterdir() if path.is_dir()}
"""Names of our distributions. Drop one here when it is published."""
PAGES = [
    path
    for pattern in (
        "*.md",
        "docs/**/*.md",
        "packages/*/README.md",
        "examples/*.py",
        "results/*.md",
        "lab/releasing/*.py",
        "packages/*/src/**/*.py",
    )
    for path in sorted(ROOT.glob(pattern))
]
COMMAND = re.compile(r"(?:pip3?|uv pip|pipx|uv tool|uv) (?:install|add)\s+([^\n`;|&]*)")


def from_the_index(text: str) -> list[str]:
    """Return our names that commands in a text install from the index, and not from git, a wheel or a folder."""
    text = text.replace("\\\n", " ")
    found = []
    for arguments in COMMAND.findall(text):
        try:
            words = shlex.split(arguments, comments=True)
        except ValueError:  # a quote of the sentence around it
            words = re.split(r"[\s'\"]+", arguments)
        for word in words:
            name = re.match(r"([A-Za-z0-9._-]+)(\[[^\]]*\])?(.*)", word.strip("'\",()"))
            if name and re.sub(r"[-_.]+", "-", name[1]).lower() in OURS and not name[3].strip().startswith("@"):
                found.append(word)
    return found


@pytest.mark.parametrize(
    ("command", "found"),
    [
        ("pip install stucksolver", ["stucksolver"]),
        ("run `pip install 'stucksolver[sim,words]'` first", ["stucksolver[sim,words]"]),
        ("python -m pip install -U StuckSolver==1.0", ["StuckSolver==1.0"]),
        ("uv add stucksolver # why", ["stucksolver"]),
        ("pip install numpy \\\n  carlette", ["carlette"]),
        ('pip install "carlette @ git+URL#subdirectory=packages/carlette" "stucksolver[sim] @ git+URL"', []),
        ('pip install carlette-*.whl "$(ls stucksolver-*.whl)[sim]"', []),
        ("pip install -e packages/carlette -e .", []),
        ("pip install 'carla>=0.9.15'", []),
    ],
)
def test_from_the_index_finds_our_names_only_without_a_source(command, found):
    assert from_the_index(command) == found


def test_pages_and_messages_install_nothing_unpublished_from_the_index():
    """All pages, and all messages in the source."""
    found = {str(page.relative_to(ROOT)): from_the_index(page.read_text(encoding="utf-8")) for page in PAGES}
    assert len(found) > 500
    assert {page: names for page, names in found.items() if names} == {}
