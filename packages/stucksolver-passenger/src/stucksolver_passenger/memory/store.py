"""The memory file: entries in SQLite, safe against crashes, concurrent processes, a full disk and unlimited growth."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from stucksolver.privacy.private_files import make_private
from stucksolver_passenger.memory.database_schema import APPLICATION_ID, MIGRATIONS, migrate, version_of
from stucksolver_passenger.memory.tried_solution import TriedSolution

MOST_EPISODES = 10_000
"""Maximum number of entries (about 20 MB of file). The oldest are deleted first. Ours."""
MOST_DAYS = 365
"""Maximum age of an entry (days).

Older ones are deleted: streets and cars change, and utterances must not be stored indefinitely. Ours.
"""
MOST_PAGES = 16_384
"""Maximum number of pages: the file never exceeds 64 MB. Ours."""
BUSY_S = 5.0
"""Time to wait for another process that writes (s). Ours."""
DAY_S = 86_400.0


class MemoryFileError(Exception):
    """A memory's file cannot be used. The message names the file, the error and the remedy."""


@dataclass(frozen=True)
class StoredSolution:
    """An entry with its number in the file."""

    number: int
    episode: TriedSolution


class SolutionStore:
    """Opens a memory's file, or creates one (mode 0600, also for an existing file).

    Any method may raise `MemoryFileError`.

    Each call has its own connection, so any thread and any process may call at any time. Deleted data is overwritten in
    the file. With `create` False, a missing file is an error.
    """

    def __init__(
        self, path: Path, *, create: bool = True, most_episodes: int = MOST_EPISODES, most_pages: int = MOST_PAGES
    ) -> None:
        self.path = path
        self._most_episodes = most_episodes
        self._most_pages = most_pages
        if not path.exists():
            if not create:
                raise MemoryFileError(f"no such memory file: {path}. Name the file from --memory")
            self._make()
        self._make_private()
        with self._open() as connection:
            migrate(connection)

    def add(self, episode: TriedSolution) -> int:
        """Store an entry and return its number. Deletes old entries beyond the limits of number and age."""
        row = (
            episode.at_s,
            episode.vehicle,
            episode.scene.obstacle,
            "" if episode.solution is None else episode.solution.name,
            episode.ending.value,
            episode.guided,
            episode.model_dump_json(exclude_none=True),
        )
        with self._open() as connection, self._writing(connection):
            columns = "at_s, vehicle, obstacle, solution, ending, guided, episode"
            added = connection.execute(f"INSERT INTO episodes ({columns}) VALUES (?, ?, ?, ?, ?, ?, ?)", row)
            connection.execute("DELETE FROM episodes WHERE at_s < ?", (episode.at_s - MOST_DAYS * DAY_S,))
            beyond = "SELECT id FROM episodes ORDER BY id DESC LIMIT 1 OFFSET ?"
            connection.execute(f"DELETE FROM episodes WHERE id <= ({beyond})", (self._most_episodes,))
            return int(added.lastrowid or 0)

    def episodes(self, obstacle: str | None = None) -> tuple[StoredSolution, ...]:
        """Return all entries, oldest first. With `obstacle`, return only those with this kind of obstacle."""
        where, values = ("", ()) if obstacle is None else (" WHERE obstacle = ?", (obstacle,))
        with self._open() as connection:
            rows = connection.execute(f"SELECT id, episode FROM episodes{where} ORDER BY id", values).fetchall()
        return tuple(StoredSolution(int(number), self._read(int(number), text)) for number, text in rows)

    def episode(self, number: int) -> StoredSolution | None:
        """Return one entry; None if the number does not exist."""
        with self._open() as connection:
            row = connection.execute("SELECT id, episode FROM episodes WHERE id = ?", (number,)).fetchone()
        return None if row is None else StoredSolution(int(row[0]), self._read(int(row[0]), row[1]))

    def forget(
        self, *, numbers: tuple[int, ...] = (), before_s: float | None = None, vehicle: str | None = None
    ) -> int:
        """Delete entries, and return their number. Nothing of them remains in the file.

        Args:
            numbers: Numbers of the entries.
            before_s: Delete all entries before this time (s since 1970).
            vehicle: Delete all entries of this vehicle.
        """
        with self._open() as connection:
            gone = 0
            with self._writing(connection):
                for number in numbers:
                    gone += connection.execute("DELETE FROM episodes WHERE id = ?", (number,)).rowcount
                if before_s is not None:
                    gone += connection.execute("DELETE FROM episodes WHERE at_s < ?", (before_s,)).rowcount
                if vehicle is not None:
                    gone += connection.execute("DELETE FROM episodes WHERE vehicle = ?", (vehicle,)).rowcount
            self._scrub(connection)
            return gone

    def forget_all(self) -> int:
        """Delete all entries, and return their number."""
        with self._open() as connection:
            with self._writing(connection):
                gone = connection.execute("DELETE FROM episodes").rowcount
            self._scrub(connection)
            return gone

    # ---- the file

    def _make(self) -> None:
        """Create an empty file that only its owner may read, because it contains utterances."""
        try:
            os.close(os.open(self.path, os.O_CREAT | os.O_WRONLY, 0o600))
        except OSError as error:
            raise MemoryFileError(
                f"cannot create memory file: {self.path}: {error.strerror}. Name a file in a writable folder"
            ) from error

    def _make_private(self) -> None:
        """Restrict an existing file and its two helper files to its owner."""
        try:
            for suffix in ("", "-wal", "-shm"):
                path = self.path.with_name(self.path.name + suffix)
                if path.exists():
                    make_private(path)
        except OSError as error:
            raise MemoryFileError(
                f"cannot restrict access to file: {self.path}: {error.strerror}. Name a file that you own"
            ) from error

    @contextmanager
    def _open(self) -> Iterator[sqlite3.Connection]:
        connection = None
        try:
            connection = sqlite3.connect(self.path, timeout=BUSY_S, isolation_level=None)
            self._prepare(connection)
            yield connection
        except sqlite3.Error as error:
            raise MemoryFileError(f"{self.path}: {_error_text(error)}") from error
        finally:
            if connection is not None:
                connection.close()

    def _prepare(self, connection: sqlite3.Connection) -> None:
        connection.execute(f"PRAGMA busy_timeout = {int(1000 * BUSY_S)}")
        known, version = int(connection.execute("PRAGMA application_id").fetchone()[0]), version_of(connection)
        empty = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0] == 0
        if known != APPLICATION_ID:
            if not empty or version:
                raise MemoryFileError(f"not a StuckSolver memory: {self.path}. Name another file")
            connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
        if version > len(MIGRATIONS):
            raise MemoryFileError(
                f"memory file of a newer StuckSolver: {self.path}: version {version}, "
                f"supported up to {len(MIGRATIONS)}. Update StuckSolver, or name another file"
            )
        # With this mode a crash loses at most the entry being written, and readers never wait for a writer.
        if connection.execute("PRAGMA journal_mode").fetchone()[0] != "wal":
            connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = NORMAL")
        connection.execute("PRAGMA secure_delete = ON")
        connection.execute(f"PRAGMA max_page_count = {self._most_pages}")

    @contextmanager
    def _writing(self, connection: sqlite3.Connection) -> Iterator[None]:
        connection.execute("BEGIN IMMEDIATE")
        try:
            yield
        except BaseException:
            if connection.in_transaction:  # a full disk has rolled it back already
                connection.execute("ROLLBACK")
            raise
        connection.execute("COMMIT")

    def _scrub(self, connection: sqlite3.Connection) -> None:
        """Remove deleted data from free pages and from the write-ahead log.

        The order matters: VACUUM writes to the log, which the checkpoint then truncates.
        """
        connection.execute("VACUUM")
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")

    def _read(self, number: int, text: str) -> TriedSolution:
        try:
            return TriedSolution.model_validate_json(text)
        except ValidationError as error:
            what = error.errors()[0]
            raise MemoryFileError(
                f"cannot read entry {number} of file: {self.path}: {what['msg']}. Delete it with "
                f"`stucksolver memory forget {self.path} {number}`"
            ) from error


def _error_text(error: sqlite3.Error) -> str:
    """Return the error of a file and the remedy."""
    text = str(error)
    if "not a database" in text:
        return "not a StuckSolver memory. Name another file"
    if "malformed" in text or "corrupt" in text:
        return "the file is damaged. Restore a copy of it, or move it away and start a new one"
    if "full" in text:
        return "the disk or the memory is full. Free space, or delete entries (`stucksolver memory forget`)"
    if "locked" in text or "busy" in text:
        return f"another program has been writing for {BUSY_S:g} s. Try again when it has ended"
    if "readonly" in text or "unable to open" in text:
        return "the file or its folder is not writable. Change that, or name another file"
    return f"{text}. Name another file"
