"""Stores the heads of records in a separate file, to detect a chain that was rewritten from its first line.

A file of heads has one line for each record, `HASH  LINE  PATH`, like the files of `sha256sum`. It can be signed,
timestamped, or kept out of reach of the records' writer. It then proves later that no record was changed up to that
line. A record may grow after its head was stored.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from stucksolver.record.hash_chain import RecordError, read_digests

_LINE = re.compile(r"([0-9a-f]{64})  ([1-9][0-9]*)  (.+)")


@dataclass(frozen=True)
class Anchor:
    """Hash in a line (counted from 1) of a record."""

    line: int
    digest: str


def head_of(record: Path) -> Anchor:
    """Return the last complete line of a record.

    Raises:
        RecordError: The record has no complete line.
    """
    digests = read_digests(record)
    if not digests:
        raise RecordError(f"{record}: no complete line, so the record has no head")
    return Anchor(len(digests), digests[-1])


def check_anchor(record: Path, anchor: Anchor) -> None:
    """Check a record against an anchor.

    Raises:
        RecordError: The anchor belongs to another record, or the end of the record was cut off.
    """
    digests = read_digests(record)
    if len(digests) < anchor.line:
        raise RecordError(
            f"{record}: its anchor is for line {anchor.line}, but the record has only {len(digests)} lines; "
            "its end was cut off"
        )
    digest = digests[anchor.line - 1]
    if digest != anchor.digest:
        raise RecordError(
            f"{record}, line {anchor.line}: hash {digest[:16]}… differs from its anchor {anchor.digest[:16]}…; "
            "the record was rewritten, or the anchor belongs to another record"
        )


def write_heads(path: Path, records: Iterable[Path]) -> Mapping[Path, Anchor]:
    """Write the heads of records to a new file. An existing file is never overwritten.

    Raises:
        RecordError: The file exists or cannot be written.
    """
    heads = {record: head_of(record) for record in records}
    text = "".join(f"{head.digest}  {head.line}  {record.as_posix()}\n" for record, head in heads.items())
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise RecordError(f"cannot write {path}: {error.strerror}; name a new file in an existing folder") from error
    return heads


def read_heads(path: Path) -> dict[Path, Anchor]:
    """Return the anchors in a file of heads, by the record's name in the file.

    Raises:
        RecordError: The file cannot be read or has an error.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise RecordError(f"cannot read {path}: {error}; give a file made with `replay --save-heads`") from error
    heads: dict[Path, Anchor] = {}
    for number, line in enumerate(lines, 1):
        match = _LINE.fullmatch(line)
        if match is None or Path(match[3]) in heads:
            raise RecordError(f"{path}, line {number}: expected `HASH  LINE  PATH`, each record once")
        heads[Path(match[3])] = Anchor(int(match[2]), match[1])
    if not heads:
        raise RecordError(f"{path}: the file names no record")
    return heads
