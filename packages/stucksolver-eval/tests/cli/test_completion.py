"""The completion scripts, as bash uses them."""

from __future__ import annotations

import contextlib
import io
import subprocess
import sys

import pytest

from stucksolver.commands import main
from stucksolver.commands.command_table import commands

pytest.importorskip("shtab")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with bash's script."""
    found = tmp_path_factory.mktemp("completion")
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        assert main(["completion", "bash"]) == 0
    (found / "bash").write_text(out.getvalue(), encoding="utf-8")
    return found


def completed(words: list[str], folder) -> set[str]:
    listed = " ".join(f"'{word}'" for word in words)
    program = f"source ./bash; COMP_WORDS=({listed}); COMP_CWORD={len(words) - 1}; "
    program += "$(complete -p stucksolver | sed 's/.*-F \\([^ ]*\\).*/\\1/'); echo ${COMPREPLY[@]}"
    command = ["bash", "--norc", "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, timeout=30, cwd=folder, check=False)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.split())


def test_completion_lists_commands_subcommands_options_and_choices(folder):
    assert set(commands()) <= completed(["stucksolver", ""], folder)
    assert completed(["stucksolver", "eva"], folder) == {"evaluate"}
    assert completed(["stucksolver", "demo", "--onc"], folder) == {"--oncoming"}
    assert completed(["stucksolver", "demo", "--road", "one"], folder) == {"one_lane"}
    assert completed(["stucksolver", "config", "sh"], folder) == {"show"}
    assert "zsh" in completed(["stucksolver", "completion", ""], folder)


def test_completion_without_shtab_names_the_extra(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert main(["completion", "bash"]) == 2
    assert "[completion]" in capsys.readouterr().err
