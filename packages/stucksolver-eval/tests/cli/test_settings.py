"""Settings: which of flag, environment, file and default counts, and what is said of a file with a mistake."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from lab.commands import COMMANDS
from stucksolver.commands import main
from stucksolver.commands.command_table import commands
from stucksolver.commands.config import template
from stucksolver.commands.main import PROGRAM, _parse, _parser

KNOWN = {**commands(), **COMMANDS}


@pytest.fixture(autouse=True)
def nothing_set(monkeypatch, tmp_path):
    """An empty folder, a user without a file, no variables of ours."""
    for name in [name for name in os.environ if name.startswith("STUCKSOLVER_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "xdg"))
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")


def parsed(*told: str):
    command = next(word for word in told if word in KNOWN)
    return _parse(_parser(PROGRAM, KNOWN, filled=[command]), told, command, KNOWN)


def write(text: str, name: str = "stucksolver.toml") -> None:
    Path(name).parent.mkdir(parents=True, exist_ok=True)
    Path(name).write_text(text, encoding="utf-8")


def test_each_place_beats_the_next_one(monkeypatch):
    assert parsed("demo").seed == 1
    write("[all]\nseed = 2\n")
    assert parsed("demo").seed == 2
    write("[all]\nseed = 2\n[demo]\nseed = 3\n")
    assert parsed("demo").seed == 3 and parsed("ride").seed == 2
    monkeypatch.setenv("STUCKSOLVER_ALL_SEED", "4")
    assert parsed("demo").seed == 4
    monkeypatch.setenv("STUCKSOLVER_DEMO_SEED", "5")
    assert parsed("demo").seed == 5 and parsed("ride").seed == 4
    assert parsed("demo", "--seed", "6").seed == 6


def test_a_flag_with_the_default_value_still_beats_the_file():
    write("[demo]\nseed = 3\n")
    assert parsed("demo", "--seed", "1").seed == 1


def test_settings_file_precedence_is_flag_variable_folder_user(monkeypatch, tmp_path):
    """The file is that of --config, then of STUCKSOLVER_CONFIG, then of this folder, then of the user."""
    write("[demo]\nseed = 1001\n", str(tmp_path / "xdg" / "stucksolver" / "config.toml"))
    assert parsed("demo").seed == 1001
    write("[demo]\nseed = 1002\n")
    assert parsed("demo").seed == 1002
    write("[demo]\nseed = 1003\n", "other.toml")
    monkeypatch.setenv("STUCKSOLVER_CONFIG", "other.toml")
    assert parsed("demo").seed == 1003
    write("[demo]\nseed = 1004\n", "told.toml")
    assert parsed("--config", "told.toml", "demo").seed == 1004
    assert parsed("--config", "none", "demo").seed == 1


def test_settings_file_supplies_required_option_and_flag_replaces_list():
    """The file may contain a required option; a flag replaces a list of the file."""
    write('[evaluate]\nsuite = "dev"\nout = "here"\nsweep = ["v_min=3,5"]\nresume = true\n')
    options = parsed("evaluate")
    assert (options.suite, str(options.out), options.sweep, options.resume) == ("dev", "here", ["v_min=3,5"], True)
    assert parsed("evaluate", "--sweep", "dt=1").sweep == ["dt=1"]


@pytest.mark.parametrize(
    ("flag", "seeds", "seed"), [((), "7,8", 1), (("--seed", "3"), None, 3), (("--seed", "1"), None, 1)]
)
def test_settings_seed_flag_overrides_seeds_of_file(flag, seeds, seed):
    """One seed on the command line replaces several in the file."""
    write('[evaluate]\nsuite = "dev"\nout = "here"\nseeds = "7,8"\n')
    options = parsed("evaluate", *flag)
    assert (options.seeds, options.seed) == (seeds, seed)


def test_settings_subcommand_has_section_and_flag_overrides_excluded_setting():
    """A subcommand has its own section, and a flag removes the setting that it excludes."""
    write('[perception.collect]\nsuite = "dev"\nout = "data"\n')
    assert parsed("perception", "collect").suite == "dev"
    options = parsed("perception", "collect", "--towns", "Town01")
    assert (options.suite, options.towns) == ("", "Town01")


def test_what_was_taken_from_elsewhere_is_said(capsys, monkeypatch):
    monkeypatch.setenv("STUCKSOLVER_DEMO_SEED", "5")
    parsed("demo")
    assert "seed 5, from STUCKSOLVER_DEMO_SEED" in capsys.readouterr().err
    parsed("demo", "--seed", "6")
    assert capsys.readouterr().err == ""


def test_help_names_what_the_file_says_as_the_default(capsys):
    write("[demo]\nseed = 41\n")
    with pytest.raises(SystemExit):
        main(["demo", "--help"])
    assert "default: 41, from stucksolver.toml" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[demo]\nsede = 3\n", "stucksolver.toml: [demo] has no setting 'sede'; did you mean 'seed'?"),
        ("[dmeo]\nseed = 3\n", "there is no section [dmeo]; did you mean 'demo'?"),
        ("[all]\nsede = 3\n", "[all] has no setting 'sede'; did you mean 'seed'?"),
        ("[ride]\nsede = 3\n", "[ride] has no setting 'sede'"),
        ("seed = 3\n", "'seed' is outside any section"),
        ("[demo]\nseed = 'x'\n", "stucksolver.toml: [demo] seed: expected a whole number, got 'x'"),
        ("[demo]\nseed = true\n", "[demo] seed: expected one value, got True"),
        ("[demo]\nseed = [1]\n", "[demo] seed: expected one value, got [1]"),
        ("[demo]\nroad = 'mud'\n", "[demo] road: invalid value 'mud'; choose from any, one_lane, multi_lane"),
        ("[ride]\nonce = 'yes'\n", "[ride] once: expected true or false, got 'yes'"),
        ("[evaluate]\nsweep = 'v_min=3'\n", "[evaluate] sweep: expected a list, got 'v_min=3'"),
        ("[memory.forgot]\ndays = 1\n", "did you mean 'memory.forget'?"),
        ("[evaluate]\nunguarded = true\n", "[evaluate] has no setting 'unguarded'"),
        ("[demo\n", "stucksolver.toml cannot be read"),
    ],
)
def test_settings_invalid_file_is_one_line_error(capsys, text, told):
    """A mistake in the file is an error of one line that names it."""
    write(text)
    assert main(["demo"]) == 2
    said = capsys.readouterr()
    assert told in said.err and said.err.count("\n") == 1 and not said.out


@pytest.mark.parametrize(("value", "told"), [("x", "STUCKSOLVER_DEMO_SEED: expected a whole number, got 'x'")])
def test_a_mistake_in_a_variable_names_the_variable(capsys, monkeypatch, value, told):
    monkeypatch.setenv("STUCKSOLVER_DEMO_SEED", value)
    assert main(["demo"]) == 2
    assert told in capsys.readouterr().err


def test_settings_named_missing_file_is_an_error(capsys):
    """A file that --config names must exist."""
    assert main(["--config", "gone.toml", "demo"]) == 2
    assert "gone.toml: no such configuration file" in capsys.readouterr().err


def test_settings_init_file_explains_settings_and_keeps_defaults(capsys):
    """The file of config init explains every setting, changes no default, and is not overwritten."""
    assert main(["config", "init"]) == 0
    assert main(["config", "init"]) == 2, "it is not written over"
    used = "\n".join(
        line.removeprefix("# ") if " = " in line and line[:2] == "# " else line for line in template().splitlines()
    )
    write(used)
    capsys.readouterr()
    assert main(["config", "show", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    sections = {row["section"] for row in told["settings"]}
    assert {"demo", "ride", "evaluate", "watch", "cases"} <= sections
    for command in ("demo", "ride"):
        plain, same = parsed("--config", "none", command), parsed(command)
        ours = {"config", "run"}
        assert {k: v for k, v in vars(same).items() if k not in ours} == {
            k: v for k, v in vars(plain).items() if k not in ours
        }


def test_show_says_what_counts_and_where_it_comes_from(capsys, monkeypatch):
    write("[demo]\nseed = 3\n")
    monkeypatch.setenv("STUCKSOLVER_RIDE_SEED", "5")
    assert main(["config", "show"]) == 0
    out = capsys.readouterr().out
    assert "demo.seed = 3  (stucksolver.toml)" in out and "ride.seed = 5  (STUCKSOLVER_RIDE_SEED)" in out
    assert main(["config", "show", "demo", "--defaults"]) == 0
    out = capsys.readouterr().out
    assert 'demo.map = "demo_town"  (default)' in out and "ride." not in out
    assert main(["config", "show", "dance"]) == 2


def test_the_folders_of_maps_in_the_environment_beat_the_file(monkeypatch):
    write('[all]\nmaps = "from/file"\n')
    assert parsed("demo").maps == "from/file"
    monkeypatch.setenv("STUCKSOLVER_MAPS", "from/environment")
    assert parsed("demo").maps is None, "the simulator reads the variable by itself"
