"""A network is checked when it is loaded; the message names the file and the remedy."""

import hashlib
import json
from pathlib import Path

import pytest

from stucksolver_perception.network_files import NetworkFileError, load_card, load_session


def put(folder: Path, weights: bytes, **card: object) -> tuple[Path, Path]:
    file, beside = folder / "net.onnx", folder / "net.json"
    file.write_bytes(weights)
    beside.write_text(
        json.dumps({"version": 1, "sha256": hashlib.sha256(weights).hexdigest(), **card}), encoding="utf-8"
    )
    return file, beside


def test_a_missing_card_or_network_is_named(tmp_path: Path) -> None:
    with pytest.raises(NetworkFileError, match=r"net\.json.*cannot be read.*reinstall"):
        load_session(tmp_path / "net.onnx", tmp_path / "net.json", 1)
    file, card = put(tmp_path, b"x")
    file.unlink()
    with pytest.raises(NetworkFileError, match=r"net\.onnx.*cannot be read.*reinstall"):
        load_session(file, card, 1)


def test_another_version_is_refused(tmp_path: Path) -> None:
    _, card = put(tmp_path, b"x", version=2)
    with pytest.raises(NetworkFileError, match="version 2; expected version 1"):
        load_card(card, 1)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"version": 1}', "\x00"])
def test_a_damaged_card_is_refused(tmp_path: Path, text: str) -> None:
    card = tmp_path / "net.json"
    card.write_text(text, encoding="utf-8")
    with pytest.raises(NetworkFileError, match="damaged"):
        load_card(card, 1)


def test_damaged_weights_are_refused(tmp_path: Path) -> None:
    file, card = put(tmp_path, b"as they were")
    file.write_bytes(b"as they are")
    with pytest.raises(NetworkFileError, match=r"net\.onnx.*damaged"):
        load_session(file, card, 1)


def test_weights_that_onnxruntime_cannot_read_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("onnxruntime")
    file, card = put(tmp_path, b"no network at all")
    with pytest.raises(NetworkFileError, match=r"net\.onnx.*cannot load"):
        load_session(file, card, 1)
