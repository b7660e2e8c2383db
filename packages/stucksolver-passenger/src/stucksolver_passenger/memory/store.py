"""The file: episodes in SQLite, safe against crashes, concurrent processes, a full disk, and unlimited growth."""

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
"""The oldest are dropped when there are more: some 20 MB of file."""
MOST_DAYS = 365
"""Older episodes are dropped: streets and cars change, and nobody's words should be kept for ever."""
MOST_PAGES = 16_384
"""The file never grows beyond 64 MB."""
BUSY_S = 5.0
"""How long to wait for another process that writes."""
DAY_S = 86_400.0


class MemoryFileError(Exception):
    """A memory's file cannot be used. The message names the file, what is wrong, and what to do."""


@dataclass(frozen=True)
class StoredSolution:
    """An episode with its number in the file."""

    number: int
    episode: TriedSolution


class SolutionStore:
    """Opens a memory's file, or makes one (mode 0600, also if it existed). Every method may raise `MemoryFileError`.

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
                raise MemoryFileError(f"{path}: no such memory file; name the file that was given as --memory")
            self._make()
        self._make_private()
        with self._open() as connection:
            migrate(connection)

    def add(self, episode: TriedSolution) -> int:
        """Store an episode and return its number. Old episodes are dropped if there are too many or they are too
        old.
        """
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
        """Return all episodes, oldest first; only those with this kind of `obstacle` if one is given."""
        where, values = ("", ()) if obstacle is None else (" WHERE obstacle = ?", (obstacle,))
        with self._open() as connection:
            rows = connection.execute(f"SELECT id, episode FROM episodes{where} ORDER BY id", values).fetchall()
        return tuple(StoredSolution(int(number), self._read(int(number), text)) for number, text in rows)

    def episode(self, number: int) -> StoredSolution | None:
        """Return one episode; None if there is none with this number."""
        with self._open() as connection:
            row = connection.execute("SELECT id, episode FROM episodes WHERE id = ?", (number,)).fetchone()
        return None if row is None else StoredSolution(int(row[0]), self._read(int(row[0]), row[1]))

    def forget(
        self, *, numbers: tuple[int, ...] = (), before_s: float | None = None, vehicle: str | None = None
    ) -> int:
        """Delete episodes, and return how many there were. Nothing of them is left in the file.

        Args:
            numbers: Their numbers.
            before_s: All before this time (s since 1970).
            vehicle: All of this vehicle.
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
        """Delete everything, and return how many episodes there were."""
        with self._open() as connection:
            with self._writing(connection):
                gone = connection.execute("DELETE FROM episodes").rowcount
            self._scrub(connection)
            return gone

    # ---- the file

    def _make(self) -> None:
        """Make an empty file that only its owner may read, because it holds what people said."""
        try:
            os.close(os.open(self.path, os.O_CREAT | os.O_WRONLY, 0o600))
        except OSError as error:
            raise MemoryFileError(
                f"{self.path}: the memory cannot be made: {error.strerror}; name a file in a folder that can be written"
            ) from error

    def _make_private(self) -> None:
        """Take a file that existed before, with its two helper files, away from everybody but its owner."""
        try:
            for suffix in ("", "-wal", "-shm"):
                path = self.path.with_name(self.path.name + suffix)
                if path.exists():
                    make_private(path)
        except OSError as error:
            raise MemoryFileError(
                f"{self.path}: others may read it, and that cannot be changed: {error.strerror}; name a file of yours"
            ) from error

    @contextmanager
    def _open(self) -> Iterator[sqlite3.Connection]:
        connection = None
        try:
            connection = sqlite3.connect(self.path, timeout=BUSY_S, isolation_level=None)
            self._prepare(connection)
            yield connection
        except sqlite3.Error as error:
            raise MemoryFileError(f"{self.path}: {_said(error)}") from error
        finally:
            if connection is not None:
                connection.close()

    def _prepare(self, connection: sqlite3.Connection) -> None:
        connection.execute(f"PRAGMA busy_timeout = {int(1000 * BUSY_S)}")
        known, version = int(connection.execute("PRAGMA application_id").fetchone()[0]), version_of(connection)
        empty = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0] == 0
        if known != APPLICATION_ID:
            if not empty or version:
                raise MemoryFileError(f"{self.path}: this is not a StuckSolver memory; name another file")
            connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
        if version > len(MIGRATIONS):
            raise MemoryFileError(
                f"{self.path}: written by a newer StuckSolver (version {version} of the file, {len(MIGRATIONS)} is "
                "known here); update StuckSolver, or name another file"
            )
        # A crash loses at most the episode being written, and readers never wait for a writer.
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
        """Remove deleted data from free pages and from the write-ahead log."""
        connection.execute("VACUUM")
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")

    def _read(self, number: int, text: str) -> TriedSolution:
        try:
            return TriedSolution.model_validate_json(text)
        except ValidationError as error:
            what = error.errors()[0]
            raise MemoryFileError(
                f"{self.path}: episode {number} cannot be read ({what['msg']}); delete it with "
                f"`stucksolver memory forget {self.path} {number}`"
            ) from error


def _said(error: sqlite3.Error) -> str:
    """Return what is wrong with a file and what to do about it."""
    text = str(error)
    if "not a database" in text:
        return "this is not a StuckSolver memory; name another file"
    if "malformed" in text or "corrupt" in text:
        return "the file is damaged; restore a copy of it, or move it away and start a new one"
    if "full" in text:
        return "the disk, or the memory itself, is full; make room, or forget something (`stucksolver memory forget`)"
    if "locked" in text or "busy" in text:
        return f"another program has been writing for {BUSY_S:g} s; try again when it has ended"
    if "readonly" in text or "unable to open" in text:
        return "the file, or its folder, cannot be written; change that, or name another file"
    return f"{text}; name another file"
