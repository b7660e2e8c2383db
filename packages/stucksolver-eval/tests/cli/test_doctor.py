"""`stucksolver doctor`: what it finds here, what it says of what is not there, and its exit code."""

from __future__ import annotations

import json
import socket
import subprocess
import sys

import pytest

from stucksolver.commands.main import main


def told(capsys, *arguments):
    code = main(["doctor", *arguments])
    return code, capsys.readouterr().out


@pytest.mark.integration
def test_in_this_environment_everything_that_the_demonstration_needs_is_there(capsys):
    code, out = told(capsys, "--json")
    found = {load["name"]: load for load in json.loads(out)}
    assert code == 0
    assert all(item["state"] == "ok" for item in found.values() if item["needed"])
    assert "started and answered" in found["carlette"]["detail"]
    assert found["reader of words"]["state"] == "ok"


@pytest.mark.integration
def test_what_is_not_there_is_told_with_its_remedy_and_fails_where_it_is_needed(capsys):
    blocked = "import sys; sys.modules['carla'] = sys.modules['onnxruntime'] = sys.modules['openai'] = None; "
    hides = (
        "import importlib.util as u; found = u.find_spec; "
        "u.find_spec = lambda n, *a: None if sys.modules.get(n, 0) is None else found(n, *a); "
    )
    program = blocked + hides + "from stucksolver.commands.main import main; sys.exit(main(['doctor']))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    said = " ".join(done.stdout.split())
    assert done.returncode == 1
    assert "missing carla: the client of CARLA and carlette; add the extra [carla] (README, Install)" in said
    assert "absent reader of words" in said and "install stucksolver-language again" in said
    assert "carlette:" not in said, "without its client it is not tried"
    assert not done.stderr


def test_a_folder_of_maps_that_is_not_there_is_named(capsys, monkeypatch, tmp_path):
    from stucksolver_eval.commands import checks

    monkeypatch.setenv("STUCKSOLVER_MAPS", str(tmp_path / "towns"))
    [found] = checks._maps()
    assert found.state == "broken" and str(tmp_path / "towns") in found.detail
    (tmp_path / "towns").mkdir()
    (tmp_path / "towns" / "Town99.xodr").touch()
    [found] = checks._maps()
    assert (found.state, "Town99" in found.detail) == ("ok", True)


def test_a_key_or_a_server_is_a_language_model(monkeypatch):
    from stucksolver_language.commands import checks

    for name in ("OPENAI_API_KEY", "OPENAI_BASE_URL"):
        monkeypatch.delenv(name, raising=False)
    assert next(checks._model()).state == "absent"
    monkeypatch.setenv("OPENAI_API_KEY", "sk-secret")
    found = next(checks._model())
    assert found.state == "ok" and "secret" not in found.detail


def test_what_listens_where_carla_would_is_asked_whether_it_is_carla(monkeypatch):
    pytest.importorskip("carla")
    from stucksolver_carla.commands import checks

    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        monkeypatch.setattr(checks, "CARLA_PORT", other.getsockname()[1])
        monkeypatch.setattr(checks, "ANSWER_LIMIT_S", 0.3)
        [found] = checks._server()
    assert found.state == "broken" and "--port" in found.remedy
    monkeypatch.setattr(checks, "CARLA_PORT", 9)
    [found] = checks._server()
    assert found.state == "absent" and "127.0.0.1:9" in found.detail


def test_a_machine_without_a_browser_is_told_what_to_install(monkeypatch, tmp_path):
    from stucksolver.commands import doctor

    monkeypatch.setenv("PATH", str(tmp_path))
    [found] = doctor._browser()
    assert found.state == "absent" and "apt install chromium" in found.remedy
    (tmp_path / "firefox").write_text("#!/bin/sh\n")
    (tmp_path / "firefox").chmod(0o755)
    [found] = doctor._browser()
    assert (found.state, found.detail) == ("ok", str(tmp_path / "firefox"))


def test_a_mistake_in_the_configuration_is_found(monkeypatch, tmp_path):
    from stucksolver.commands import doctor

    monkeypatch.setenv("STUCKSOLVER_CONFIG", str(tmp_path / "mine.toml"))
    (tmp_path / "mine.toml").write_text("[demo]\nsede = 1\n")
    [found] = doctor._settings()
    assert found.state == "broken" and "did you mean 'seed'?" in found.detail
    (tmp_path / "mine.toml").write_text("[demo]\nseed = 1\n")
    [found] = doctor._settings()
    assert found.state == "ok" and "mine.toml" in found.detail


def test_ports_can_be_opened_here_and_a_system_that_forbids_it_is_named(monkeypatch):
    from stucksolver.commands import doctor

    assert next(doctor._ports()).state == "ok"

    def refuse(*_):
        raise OSError(99, "Cannot assign requested address")

    monkeypatch.setattr(doctor.socket.socket, "bind", refuse)
    found = next(doctor._ports())
    assert found.state == "broken" and "Cannot assign" in found.detail and found.remedy
