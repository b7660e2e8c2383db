"""`--json`: standard output is JSON of the documented shape and nothing else, and the exit code stays the same."""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path

import pytest

from stucksolver.commands import main
from stucksolver.commands.main import full_parser
from stucksolver.ladder import PROFILES, find_ladder

WITH_JSON = {
    "cases",
    "compare",
    "config show",
    "demo",
    "doctor",
    "evaluate",
    "ladder",
    "memory forget",
    "memory import",
    "memory list",
    "plugins",
    "prompt",
    "replay",
    "score",
    "voice status",
    "watch",
}


def parsers(parser: argparse.ArgumentParser, path: str = "") -> dict[str, argparse.ArgumentParser]:
    found = {path: parser} if path else {}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, below in action.choices.items():
                found |= parsers(below, f"{path} {name}".strip())
    return found


def printed(capsys: pytest.CaptureFixture[str], *arguments: str | Path, code: int = 0):
    """What the command printed on standard output, parsed."""
    assert main([str(argument) for argument in arguments]) == code
    return json.loads(capsys.readouterr().out)


def test_every_command_with_json_describes_its_shape_in_the_help() -> None:
    described = {}
    for name, parser in parsers(full_parser()).items():
        for action in parser._actions:
            if "--json" in action.option_strings:
                described[name] = action.help or ""
    assert set(described) == WITH_JSON
    for name, told in described.items():
        assert re.match(r"print JSON: .*", told) and len(told) > len("print JSON: ") + 10, name


@pytest.mark.parametrize("profile", PROFILES)
def test_a_ladder_is_printed_with_every_value(capsys: pytest.CaptureFixture[str], profile: str) -> None:
    told = printed(capsys, "ladder", profile, "--json")
    assert told == find_ladder(profile).model_dump(mode="json")
    assert [rung["kind"] for rung in told["rungs"]] == [rung.kind for rung in find_ladder(profile).rungs]


def test_voice_status_says_whether_it_is_installed(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    told = printed(capsys, "voice", "status", "--folder", tmp_path / "none", "--json", code=1)
    assert told == {"folder": str(tmp_path / "none"), "installed": False}


def test_settings_are_rows_with_their_source(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("STUCKSOLVER_DEMO_SEED", "7")
    (tmp_path / "s.toml").write_text("[demo]\nout = 'there'\n", encoding="utf-8")
    told = printed(capsys, "--config", tmp_path / "s.toml", "config", "show", "demo", "--json")
    rows = {row["key"]: (row["value"], row["source"]) for row in told["settings"]}
    assert told["file"] == str(tmp_path / "s.toml")
    assert rows["seed"] == (7, "STUCKSOLVER_DEMO_SEED")
    assert rows["out"] == ("there", str(tmp_path / "s.toml"))


def test_an_error_prints_nothing_on_standard_output(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    for command in (["replay", tmp_path / "no.jsonl"], ["score", tmp_path], ["ladder", tmp_path / "no.toml"]):
        assert main([*map(str, command), "--json"]) == 2
        said = capsys.readouterr()
        assert said.out == "" and said.err.startswith("error: ") and said.err.count("\n") == 1


@pytest.mark.release
@pytest.mark.slow
@pytest.mark.integration
def test_the_demonstration_prints_its_runs_and_the_report(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("carla")
    pytest.importorskip("onnxruntime", reason="the reader of words is not installed")
    from stucksolver_eval import demo

    monkeypatch.setattr(demo, "SPOKEN", demo.SPOKEN[:1])
    told = printed(capsys, "demo", "--out", tmp_path, "--no-pictures", "--say", "please go round it", "--json")
    assert Path(told["report"]).is_file()
    assert len(told["runs"]) == 1
    for run in told["runs"]:
        assert set(run) == {"scenario", "arm", "seed", "result"}
        assert run["result"]["duration_s"] > 0.0 and run["result"]["status"]
