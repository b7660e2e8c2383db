"""Lines of JSON, each with a hash over itself and the previous hash, so that any changed byte is detected."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from stucksolver.privacy.private_files import open_new
from stucksolver.scene.json_text import JsonError, read_json

_MARK = b',"hash":"'
_TAIL = len(_MARK) + 64 + len(b'"}')
START = "0" * 64
"""Hash before the first line."""
LAST_KIND = "end"
"""Kind of the line that ends a record."""
LONGEST_LINE_BYTES = 16 * 1024 * 1024
"""Longest line that is written or read (bytes): a thousand times the longest in the tests' records (18 KB)."""
_LOOKS_LIKE = "none of its lines ends in a hash, as every line of a record does"


class RecordError(RuntimeError):
    """Record that cannot be written or read. The message has the file, the line if there is one, and the remedy."""


class ChainWriter:
    """Writer of a new file. It appends each line in one call, so that a killed process leaves complete lines."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._hash = START
        self._end = 0
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = open_new(path)
        except OSError as error:
            raise _cannot_write(path, error) from error

    def write(self, data: Mapping[str, Any]) -> None:
        """Append one line.

        Raises:
            RecordError: The line cannot be written. The lines before it are complete.
        """
        body = json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode()
        digest = _digest(self._hash, body)
        line = body[:-1] + _MARK + digest.encode() + b'"}\n'
        if len(line) > LONGEST_LINE_BYTES:
            most = LONGEST_LINE_BYTES
            raise RecordError(f"cannot write {self.path}: a line of {len(line)} bytes; at most {most} are allowed")
        try:
            written = 0
            while written < len(line):
                written += self._file.write(line[written:])
        except OSError as error:
            # A partial line is removed, if possible. The error of the write is the one to report.
            with contextlib.suppress(OSError):
                self._file.truncate(self._end)
            raise _cannot_write(self.path, error) from error
        self._hash = digest
        self._end += len(line)

    def close(self) -> None:
        """Flush the file to the disk and close it."""
        # The content is already in the file; a disk that cannot flush must not end the run.
        with contextlib.suppress(OSError):
            os.fsync(self._file.fileno())
        self._file.close()


def read_chain(path: Path) -> Iterator[tuple[int, dict[str, Any]]]:
    """Yield the number, counted from 1, and the content of each line.

    An incomplete last line, which a killed process may leave, ends the reading without an error. No line may follow the
    line that ends a record.

    Raises:
        RecordError: A line was changed, is too long or cannot be read. The message has the number of the first one.
    """
    for number, (data, _) in enumerate(_checked(path), 1):
        yield number, data


def read_digests(path: Path) -> list[str]:
    """Return the hash of each complete line.

    Raises:
        RecordError: As for `read_chain`.
    """
    return [digest for _, digest in _checked(path)]


def _checked(path: Path) -> Iterator[tuple[dict[str, Any], str]]:
    """Yield each complete line's content and its hash."""
    before, ended = START, False
    number = 0
    for number, line in enumerate(_lines(path), 1):
        location = f"{path}, line {number}"
        if ended:
            raise RecordError(f"{location}: content after the record's last line; it was added later")
        whole = line.endswith(b"\n")
        line = line.removesuffix(b"\n")
        if not whole and not _looks_whole(line):
            if number == 1:
                raise _no_record(path)
            return
        if not whole:
            raise RecordError(f"{location}: the end of this line was changed after writing")
        body, digest = line[:-_TAIL] + b"}", line[-_TAIL + len(_MARK) : -2].decode("ascii", "replace")
        if not _hash_stands_in(line) or _digest(before, body) != digest:
            if number == 1 and not any(_hash_stands_in(item.removesuffix(b"\n")) for item in _lines(path)):
                raise _no_record(path)
            raise RecordError(f"{location}: changed after writing (this line, or one missing before it)")
        before = digest
        data = _object(body, location)
        ended = data.get("kind") == LAST_KIND
        yield data, digest


def _lines(path: Path) -> Iterator[bytes]:
    """Yield the lines of a file with their line feeds; the last one may lack it."""
    try:
        with path.open("rb") as file:
            number = 0
            while line := file.readline(LONGEST_LINE_BYTES + 1):
                number += 1
                if len(line) > LONGEST_LINE_BYTES:
                    raise RecordError(f"{path}, line {number}: longer than {LONGEST_LINE_BYTES} bytes; no record is")
                yield line
    except OSError as error:
        raise RecordError(f"cannot read {path}: {error.strerror}; give a file `intervention-….jsonl`") from error


def _object(body: bytes, location: str) -> dict[str, Any]:
    """Return the content of a line."""
    try:
        data = read_json(body)
    except JsonError as error:
        raise RecordError(f"{location}: this line cannot be read: {error}") from error
    if not isinstance(data, dict):
        raise RecordError(f"{location}: this line cannot be read: expected a JSON object")
    return data


def _no_record(path: Path) -> RecordError:
    return RecordError(f"{path} is not a record: {_LOOKS_LIKE}; give a file `intervention-….jsonl`")


def _hash_stands_in(line: bytes) -> bool:
    return line[-_TAIL : -_TAIL + len(_MARK)] == _MARK and line[-2:] == b'"}'


def _looks_whole(last: bytes) -> bool:
    """True if the last line has its hash but no line feed, which a killed process cannot leave."""
    mark = last.rfind(_MARK)
    return mark >= 0 and len(last) - mark >= _TAIL


def _digest(before: str, body: bytes) -> str:
    return hashlib.sha256(before.encode() + body).hexdigest()


def _cannot_write(path: Path, error: OSError) -> RecordError:
    return RecordError(f"cannot write {path}: {error.strerror}; make room or choose another folder")
