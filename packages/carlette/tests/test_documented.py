"""The documentation names every call that the server answers, and no other."""

from __future__ import annotations

import re
from pathlib import Path

from carlette.rpc.handlers import ALL

PAGE = Path(__file__).parents[3] / "docs" / "carlette.md"


def test_the_table_of_calls_is_complete_and_true() -> None:
    section = PAGE.read_text("utf-8").partition("## The calls")[2].partition("\n## ")[0]
    rows = [line for line in section.splitlines() if line.startswith("|")]
    named = re.findall(r"`(\w+)`", "".join(rows))
    assert sorted(named) == sorted([*ALL.calls, "tick_cue"])
