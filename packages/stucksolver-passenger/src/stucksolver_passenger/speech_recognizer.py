"""The speech recognizer for the passenger's browser: its packages and its installation.

The wheel does not contain it. npm fetches it once, on demand, pinned by version and by the digest of its archive. Only
the files that the page needs are installed.
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
"""Name of the manifest. It is written last, so a folder without it is incomplete."""
FETCH_S = 600.0
"""Time limit for one package (s). The largest has 21 MB. Ours."""
BLOCK_BYTES = 1 << 20
"""Block size for reading files (bytes)."""


class RecognizerError(Exception):
    """The recognizer cannot be installed. The message says why and what to do."""


@dataclass(frozen=True)
class Package:
    """An npm package.

    `integrity` is the SHA-512 of its archive in npm's form; `files` maps files to their new names.
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
    """Return the default folder in the user's data folder (XDG Base Directory Specification)."""
    configured = os.environ.get("XDG_DATA_HOME", "")
    home = Path(configured) if configured.startswith("/") else Path.home() / ".local" / "share"
    return home / "stucksolver" / KEPT_IN


def find_recognizer(folder: Path | None = None) -> Recognizer | None:
    """Return the installed recognizer; None if there is none, or if a file is missing or was changed."""
    folder = folder or usual_folder()
    try:
        digests = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))["files"]
        if any(digests.get(name) != _digest(folder / name) for name in FILES):
            return None
    except (OSError, ValueError, KeyError, AttributeError):
        # A missing or damaged file means that no recognizer is installed; the page then uses the browser's own.
        return None
    return Recognizer(folder, hashlib.sha256(json.dumps(digests, sort_keys=True).encode()).hexdigest()[:12])


def install(folder: Path | None = None, fetch: Fetch | None = None) -> Recognizer:
    """Fetch all packages and install the needed files, completely or not at all.

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
        raise RecognizerError(
            f"cannot install into folder: {folder}: {error.strerror}. Free space, or name another folder with --folder"
        ) from error
    found = find_recognizer(folder)
    assert found is not None
    return found


def remove(folder: Path | None = None) -> bool:
    """Delete an installed recognizer and nothing else. Returns False if there was none.

    Raises:
        RecognizerError: The folder contains other files.
    """
    folder = folder or usual_folder()
    if not folder.exists():
        return False
    if any(folder.iterdir()) and not (folder / MANIFEST).is_file():
        raise RecognizerError(f"folder contains other files: {folder}. Name another one with --folder")
    shutil.rmtree(folder)
    return True


def by_npm(package: Package, folder: Path) -> Path:
    """Fetch a package with npm's own client, from its configured registry.

    Raises:
        RecognizerError: npm is missing or failed.
    """
    if shutil.which("npm") is None:
        raise RecognizerError("npm not found. Install it with apt-get install npm, or use --from")
    order = ["npm", "pack", "--silent", "--ignore-scripts", f"{package.name}@{package.version}"]
    try:
        done = subprocess.run(order, cwd=folder, capture_output=True, text=True, timeout=FETCH_S, check=False)
    except subprocess.TimeoutExpired:
        raise RecognizerError(f"npm timed out after {FETCH_S:g} s: {package.name}. Try again") from None
    named = done.stdout.split()
    if done.returncode or not named:
        message = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise RecognizerError(
            f"npm cannot fetch package: {package.name} {package.version}: {message}. Try again, or use --from"
        )
    return folder / named[-1]


def from_folder(source: Path) -> Fetch:
    """Return a fetcher for machines without a network. It uses archives that `npm pack` made on another machine."""

    def fetch(package: Package, folder: Path) -> Path:
        name = f"{package.name.lstrip('@').replace('/', '-')}-{package.version}.tgz"
        if not (source / name).is_file():
            raise RecognizerError(
                f"archive not found: {source / name}. Make it with `npm pack {package.name}@{package.version}`"
            )
        return source / name

    return fetch


def check(package: Package, archive: Path) -> None:
    """Check that the archive is the pinned one.

    Raises:
        RecognizerError: It is another one.
    """
    found = hashlib.sha512(archive.read_bytes()).digest()
    if f"sha512-{base64.b64encode(found).decode()}" != package.integrity:
        raise RecognizerError(
            f"archive is not the published {package.name} {package.version}: {archive.name}. Nothing was installed"
        )


def _unpack(package: Package, archive: Path, folder: Path) -> None:
    """Extract only the files of the package's list, each to its new name. The rest of the archive is not read."""
    with tarfile.open(archive) as packed:
        for inside, name in package.files.items():
            member = packed.extractfile(f"package/{inside}")
            if member is None:
                raise RecognizerError(f"archive without file {inside}: {archive.name}. Nothing was installed")
            with member, (folder / name).open("wb") as out:
                shutil.copyfileobj(member, out)


def _digest(file: Path) -> str:
    found = hashlib.sha256()
    with file.open("rb") as data:
        while block := data.read(BLOCK_BYTES):
            found.update(block)
    return found.hexdigest()
