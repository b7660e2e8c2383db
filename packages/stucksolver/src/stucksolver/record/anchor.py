"""Stores the heads of records elsewhere, so that a chain that was rewritten from its first line is detected.

A file of heads has one line for each record, `HASH  LINE  PATH`, like the files of `sha256sum`. Whoever signs it,
timestamps it, or keeps it out of reach of the records' writer can later prove that nothing was changed up to that line.
A record may grow after its head was taken.
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
    """The hash in a line (counted from 1) of a record."""

    line: int
    digest: str


def head_of(record: Path) -> Anchor:
    """Return the last complete line of a record.

    Raises:
        RecordError: There is no complete line.
    """
    digests = read_digests(record)
    if not digests:
        raise RecordError(f"{record}: it has no complete line, so it has no head")
    return Anchor(len(digests), digests[-1])


def check_anchor(record: Path, anchor: Anchor) -> None:
    """Check a record against an anchor.

    Raises:
        RecordError: The anchor belongs to another record, or the record's end was cut off.
    """
    digests = read_digests(record)
    if len(digests) < anchor.line:
        raise RecordError(
            f"{record}: its anchor is for line {anchor.line}, but it has only {len(digests)} lines; its end was cut off"
        )
    found = digests[anchor.line - 1]
    if found != anchor.digest:
        raise RecordError(
            f"{record}, line {anchor.line}: its hash is {found[:16]}…, its anchor says {anchor.digest[:16]}…; "
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
    """Return the records in a file of heads, under the names used there.

    Raises:
        RecordError: The file cannot be read or has an error.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise RecordError(f"cannot read {path}: {error}; give a file made with `replay --save-heads`") from error
    heads: dict[Path, Anchor] = {}
    for number, line in enumerate(lines, 1):
        found = _LINE.fullmatch(line)
        if found is None or Path(found[3]) in heads:
            raise RecordError(f"{path}, line {number}: expected `HASH  LINE  PATH`, each record once")
        heads[Path(found[3])] = Anchor(int(found[2]), found[1])
    if not heads:
        raise RecordError(f"{path}: names no record")
    return heads
