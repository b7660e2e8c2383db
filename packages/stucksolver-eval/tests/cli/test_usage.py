"""What a command says when it is used wrongly, or asked about itself: one clear line."""

from __future__ import annotations

import argparse
import re
import socket
import subprocess
import sys
from pathlib import Path

import pytest

import carlette.cli
from stucksolver.commands import main
from stucksolver.commands.main import full_parser

EXAMPLE = Path(__file__).parents[4] / "examples" / "behavior_agent.py"


def refused(capsys, *arguments: str, program=main) -> str:
    """The one line of a command that was refused."""
    try:
        program(list(arguments))
        code = 0
    except SystemExit as ended:
        code = ended.code
    said = capsys.readouterr()
    assert code == 2 and said.out == ""
    assert said.err.count("\n") == 1, said.err
    return said.err


@pytest.mark.parametrize(
    ("command", "told"),
    [
        ("watch --port abc", "--port: expected a port from 1 to 65535, got 'abc'"),
        ("demo --port 0", "--port: expected a port from 1 to 65535, got '0'"),
        ("evaluate --suite dev --out x --port 65536", "got '65536'"),
        ("demo --oncoming -3", "--oncoming: expected a whole number from 0 on, got '-3'"),
        ("demo --oncoming 1.5", "--oncoming: expected a whole number from 0 on, got '1.5'"),
        ("demo --seed x", "--seed: expected a whole number, got 'x'"),
        ("watch --seconds -1", "--seconds: expected a number above 0, got '-1'"),
        ("watch --seconds nan", "--seconds: expected a number above 0, got 'nan'"),
        ("cases --deadline 0", "--deadline: expected a number above 0, got '0'"),
        ("cases --tries 0", "--tries: expected a whole number from 1 on, got '0'"),
        ("evaluate --suite dev --out x --jobs 0", "--jobs: expected a whole number from 1 on, got '0'"),
        ("evaluate --suite dev", "required: --out"),
        ("dance", "'dance'"),
    ],
)
def test_command_invalid_value_error_names_option_and_format(capsys, command, told):
    """An invalid value is an error of one line that names the option and the values that it takes."""
    # Only read: what was accepted by mistake must not be driven.
    assert told in refused(capsys, *command.split(), program=full_parser().parse_args)


@pytest.mark.parametrize(
    ("command", "told"),
    [
        ("--port abc", "--port: not a port: 'abc'. Give a number from 0 to 65534"),
        ("--port 65535", "--port: not a port: '65535'"),
        ("--seed x", "--seed"),
        ("--maps", "--maps"),
    ],
)
def test_so_it_is_with_the_simulator(capsys, command, told):
    assert told in refused(capsys, *command.split(), program=carlette.cli.main)


@pytest.mark.parametrize(("program", "name"), [(main, "stucksolver"), (carlette.cli.main, "carlette")])
def test_the_version_is_told(capsys, program, name):
    with pytest.raises(SystemExit) as ended:
        program(["--version"])
    assert ended.value.code == 0
    assert re.fullmatch(rf"{name} \d+\.\d+\S*\n", capsys.readouterr().out)


def commands() -> dict[str, argparse.ArgumentParser]:
    (found,) = [a for a in full_parser()._actions if isinstance(a, argparse._SubParsersAction)]
    return {**found.choices, "carlette": carlette.cli._parser()}


@pytest.mark.parametrize("name", commands())
def test_the_help_names_every_default_and_explains_every_argument(name):
    parser = commands()[name]
    told = " ".join(parser.format_help().split())
    assert parser.description, "a command says what it does"
    for action in parser._actions:
        assert action.help, action.dest
        if action.option_strings and action.default not in (None, False, (), "", argparse.SUPPRESS, []):
            assert re.search(rf"default: {re.escape(str(action.default))}\b", told), action.dest
    assert "default: )" not in told, "a default that is empty says nothing"


def test_compare_help_explains_arguments_and_output(capsys):
    """The help of compare explains A and B, the difference and its interval."""
    with pytest.raises(SystemExit):
        main(["compare", "--help"])
    told = " ".join(capsys.readouterr().out.split())
    assert "`evaluate --out`" in told and "B - A" in told and "95 %" in told


def test_ctrl_c_names_the_way_to_go_on(capsys, monkeypatch, tmp_path):
    pytest.importorskip("carla")
    from stucksolver_eval.runner import evaluate

    def interrupted(spec):
        raise KeyboardInterrupt

    monkeypatch.setattr(evaluate, "evaluate", interrupted)
    assert main(["evaluate", "--suite", "dev", "--out", str(tmp_path)]) == 130
    error = capsys.readouterr().err.strip()
    assert (
        error.splitlines()[-1]
        == "interrupted; finished routes are stored: run the same command with --resume to continue"
    )


def test_evaluate_absent_server_fails_before_suite_starts(capsys, tmp_path):
    """An absent server is reported before the suite starts, and no output folder is created."""
    pytest.importorskip("carla")
    with socket.create_server(("127.0.0.1", 0)) as gone:
        port = gone.getsockname()[1]
    command = f"evaluate --suite dev --recovery search --host 127.0.0.1 --port {port} --out {tmp_path / 'out'}"
    assert f"no CARLA server at 127.0.0.1:{port}" in refused(capsys, *command.split(), program=ending)
    assert not (tmp_path / "out").exists()


def ending(arguments: list[str]) -> None:
    raise SystemExit(main(arguments))


# ---- what is not installed

HIDE = """
import sys
class Hidden:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {missing!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Hidden())
"""


def without(missing: tuple[str, ...], program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a program where some packages cannot be found."""
    command = [sys.executable, "-c", HIDE.format(missing=missing) + program, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60)


CARLETTE = "from carlette.cli import main; sys.exit(main(sys.argv[1:]))"
RUN_EXAMPLE = f"import runpy; sys.argv[0] = {str(EXAMPLE)!r}; runpy.run_path(sys.argv[0], run_name='__main__')"


def test_the_simulator_without_its_extra_names_it_in_one_line():
    done = without(("carla", "msgpack", "numba"), CARLETTE, "--port", "0")
    assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
    assert "carla, msgpack, numba" in done.stderr and "pip install carla msgpack numba" in done.stderr


def test_one_missing_package_is_named_too():
    done = without(("msgpack",), CARLETTE, "--port", "0")
    assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
    assert "msgpack" in done.stderr and "numba" not in done.stderr


@pytest.mark.parametrize(
    ("missing", "told"),
    [
        (("carla",), "pip install 'carla>=0.9.15'"),
        (("agents",), "PythonAPI/carla"),
    ],
)
def test_the_example_says_what_it_lacks_in_one_line(missing, told):
    done = without(missing, RUN_EXAMPLE)
    assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
    assert told in done.stderr


AGENTS = """
import types
for name in ("agents", "agents.navigation", "agents.navigation.behavior_agent"):
    sys.modules[name] = types.ModuleType(name)
sys.modules["agents.navigation.behavior_agent"].BehaviorAgent = object
"""


@pytest.mark.integration
@pytest.mark.parametrize(
    ("arguments", "told"),
    [(("127.0.0.1", "9"), "no CARLA server at 127.0.0.1:9"), (("127.0.0.1", "abc"), "'abc' is not a port")],
)
def test_the_example_says_that_nobody_serves_it_in_one_line(arguments, told):
    pytest.importorskip("carla")
    done = without((), AGENTS + RUN_EXAMPLE, *arguments)
    assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
    assert told in done.stderr


@pytest.mark.integration
def test_command_closed_output_pipe_ends_without_traceback():
    """The command ends without a traceback when the reader of its output closes the pipe."""
    program = "import sys; from stucksolver.commands.main import main; sys.exit(main(['ladder']))"
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode in (0, 141)


@pytest.mark.parametrize("asked", ["import stucksolver", "main(['--help'])", "main(['--version'])"])
def test_help_comes_at_once_since_nothing_is_imported_for_it(asked):
    program = (
        "import contextlib, sys\n"
        "from stucksolver.commands.main import main\n"
        f"with contextlib.suppress(SystemExit):\n    {asked}\n"
        "print(sorted({'numpy', 'pydantic', 'carla', 'shapely', 'openai'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_whatever_the_package_offers_is_there():
    import stucksolver

    assert set(stucksolver.__all__) <= set(dir(stucksolver))
    assert all(getattr(stucksolver, name) is not None for name in stucksolver.__all__ if name != "attach")
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = stucksolver.nothing
