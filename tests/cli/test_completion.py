"""The completion scripts, asked as each shell asks them."""

from __future__ import annotations

import contextlib
import io
import shutil
import subprocess

import pytest

from stucksolver.cli import main
from stucksolver.cli.commands import COMMANDS


@pytest.fixture(scope="module")
def scripts(tmp_path_factory):
    """A folder with the script of each shell."""
    folder = tmp_path_factory.mktemp("completion")
    for shell in ("bash", "zsh", "fish"):
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            assert main(["completion", shell]) == 0
        (folder / shell).write_text(out.getvalue(), encoding="utf-8")
    return folder


def shell(name: str, program: str, folder) -> str:
    if shutil.which(name) is None:
        pytest.skip(f"{name} is not installed")
    command = [name, "--norc", "-c", program] if name == "bash" else [name, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, timeout=30, cwd=folder, check=False)
    assert done.returncode == 0 and not done.stderr, done.stderr
    return done.stdout


def in_bash(words: list[str], folder) -> set[str]:
    listed = " ".join(f"'{word}'" for word in words)
    program = f"source ./bash; COMP_WORDS=({listed}); COMP_CWORD={len(words) - 1}; _stucksolver; "
    program += "echo ${COMPREPLY[@]}"
    return set(shell("bash", program, folder).split())


def in_fish(words: list[str], folder) -> set[str]:
    out = shell("fish", f"source ./fish; complete -C '{' '.join(words)}'", folder)
    return {line.split("\t")[0] for line in out.splitlines()}


@pytest.mark.parametrize("ask", [in_bash, in_fish])
def test_commands_parts_options_and_choices_are_completed(scripts, ask):
    assert set(COMMANDS) <= ask(["stucksolver", ""], scripts)
    assert ask(["stucksolver", "eva"], scripts) == {"evaluate"}
    assert ask(["stucksolver", "demo", "--onc"], scripts) == {"--oncoming"}
    assert ask(["stucksolver", "demo", "--road", "one"], scripts) == {"one_lane"}
    assert ask(["stucksolver", "perception", "col"], scripts) == {"collect"}
    assert ask(["stucksolver", "perception", "collect", "--tow"], scripts) == {"--towns"}
    assert "--towns" not in ask(["stucksolver", "perception", "eval", "--"], scripts), "not of another part"
    assert "zsh" in ask(["stucksolver", "completion", ""], scripts)


def test_the_value_of_an_option_is_not_taken_for_a_command(scripts):
    assert "--oncoming" in in_bash(["stucksolver", "demo", "--seed", "3", "--"], scripts)


def test_zsh_reads_its_script_and_knows_the_words(scripts):
    found = shell(
        "zsh",
        "autoload -U compinit && compinit -u -D; source ./zsh; "
        "_describe() { print -l -- ${(P)2} }; _files() { print files }; compadd() { shift; print -l -- $@ }; "
        'ask() { words=(stucksolver "$@"); CURRENT=$#words; PREFIX=$words[-1]; _stucksolver }; '
        "ask ''; print -- '=='; ask demo --; print -- '=='; ask demo --road o; print -- '=='; ask perception ''",
        scripts,
    ).split("==")
    assert "evaluate:drive a suite of routes" in found[0]
    assert "--oncoming:" in found[1]
    assert found[2].split() == ["any", "one_lane", "multi_lane"]
    assert "collect:" in found[3]
