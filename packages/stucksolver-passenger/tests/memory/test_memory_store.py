"""The file: crashes, two processes, a full disk, damage, growth, versions, and forgetting."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sqlite3
import subprocess
import sys
import time

import pytest
from remembering import REROUTE, episode

from stucksolver_passenger.memory import MemoryFileError, SolutionStore
from stucksolver_passenger.memory.database_schema import MIGRATIONS, migrate, version_of
from stucksolver_passenger.memory.store import DAY_S, MOST_DAYS

WORDS = "take the lane behind the bakery, Rosalind"


@pytest.fixture
def path(tmp_path):
    return tmp_path / "memory.db"


def texts(path):
    return [kept.episode.text for kept in SolutionStore(path).episodes()]


def test_what_is_kept_comes_back_as_it_was(path):
    said = episode(text=WORDS, how="12 m", took_s=3.5, questions=2, behaviors=("replan",), proposer="rules")
    number = SolutionStore(path).add(said)
    kept = SolutionStore(path).episode(number)
    assert kept is not None and kept.episode == said and kept.episode.solution == REROUTE
    assert SolutionStore(path).episode(number + 1) is None


def test_only_the_owner_may_read_the_file(path):
    SolutionStore(path)
    assert path.stat().st_mode & 0o077 == 0


@pytest.mark.parametrize("before", [0o644, 0o660, 0o604])
def test_memory_that_others_could_read_is_taken_away_from_them(path, before):
    """With the helper files that another process has open beside it."""
    store = SolutionStore(path)
    with store._open() as connection:
        connection.execute("SELECT count(*) FROM episodes").fetchall()
        files = [file for file in path.parent.iterdir() if file.name.startswith(path.name)]
        for file in files:
            file.chmod(before)
        SolutionStore(path)
        assert {file.stat().st_mode & 0o777 for file in files if file.exists()} == {0o600}


def test_the_oldest_go_when_there_are_too_many(path):
    store = SolutionStore(path, most_episodes=5)
    for k in range(9):
        store.add(episode(text=f"word {k}"))
    assert texts(path) == [f"word {k}" for k in range(4, 9)]


def test_what_is_older_than_a_year_goes(path):
    store = SolutionStore(path)
    store.add(episode(text="old", at_s=0.0))
    store.add(episode(text="new", at_s=(MOST_DAYS + 1) * DAY_S))
    assert texts(path) == ["new"]


def test_nothing_of_what_is_forgotten_stays_in_any_file(path):
    store = SolutionStore(path)
    for k in range(30):
        store.add(episode(text=f"{WORDS} {k}"))
    assert store.forget_all() == 30
    left = b"".join(item.read_bytes() for item in path.parent.iterdir())
    assert b"Rosalind" not in left


def test_episodes_are_forgotten_by_number_time_and_vehicle(path):
    store = SolutionStore(path)
    numbers = [store.add(episode(at_s=1e9 + k, vehicle=f"car-{k % 2}")) for k in range(6)]
    assert store.forget(numbers=(numbers[0], 999)) == 1
    assert store.forget(before_s=1e9 + 2) == 1
    assert store.forget(vehicle="car-1") == 2
    assert [kept.number for kept in store.episodes()] == [numbers[2], numbers[4]]


def test_a_file_of_something_else_is_refused_and_left_alone(path):
    path.write_text("dear diary, " * 200, encoding="utf-8")
    with pytest.raises(MemoryFileError, match="not a StuckSolver memory"):
        SolutionStore(path)
    assert path.read_text(encoding="utf-8").startswith("dear diary")
    other = path.with_name("other.db")
    with sqlite3.connect(other) as connection:
        connection.execute("CREATE TABLE mine (x)")
    with pytest.raises(MemoryFileError, match="not a StuckSolver memory"):
        SolutionStore(other)


def test_a_damaged_file_is_told_with_the_remedy(path):
    store = SolutionStore(path)
    for _ in range(12):
        store.add(episode(text="x" * 500))
    for extra in path.parent.glob("memory.db-*"):
        extra.unlink()
    data = bytearray(path.read_bytes())
    data[4096:] = b"\xa5" * (len(data) - 4096)
    path.write_bytes(data)
    with pytest.raises(MemoryFileError, match=r"memory\.db: the file is damaged. Restore a copy"):
        store.episodes()


def test_a_full_disk_is_told_and_what_was_kept_stays(path):
    store = SolutionStore(path, most_pages=12)
    kept = 0
    with pytest.raises(MemoryFileError, match=r"full\. Free space"):
        for _ in range(200):
            store.add(episode(text="x" * 500))
            kept += 1
    assert 0 < kept == len(texts(path))


def test_a_folder_that_is_not_there_is_told(tmp_path):
    with pytest.raises(MemoryFileError, match="cannot create memory file"):
        SolutionStore(tmp_path / "nowhere" / "memory.db")
    with pytest.raises(MemoryFileError, match="no such memory"):
        SolutionStore(tmp_path / "memory.db", create=False)


def test_a_file_of_a_newer_version_is_refused(path):
    SolutionStore(path)
    with sqlite3.connect(path) as connection:
        connection.execute(f"PRAGMA user_version = {len(MIGRATIONS) + 1}")
    with pytest.raises(MemoryFileError, match="newer StuckSolver"):
        SolutionStore(path)


def test_store_older_file_is_migrated_with_its_entries(path):
    """An older file is migrated to the current version and keeps its entries."""
    SolutionStore(path).add(episode(text=WORDS))
    with sqlite3.connect(path, isolation_level=None) as connection:
        migrate(connection, (*MIGRATIONS, "ALTER TABLE episodes ADD COLUMN mood TEXT NOT NULL DEFAULT 'calm'"))
        assert version_of(connection) == len(MIGRATIONS) + 1
        assert connection.execute("SELECT mood FROM episodes").fetchall() == [("calm",)]


def test_a_step_of_a_migration_that_fails_changes_nothing(path):
    SolutionStore(path)
    with sqlite3.connect(path, isolation_level=None) as connection:
        with pytest.raises(sqlite3.Error):
            migrate(connection, (*MIGRATIONS, "ALTER TABLE episodes ADD COLUMN mood TEXT; SELECT * FROM nothing"))
        assert version_of(connection) == len(MIGRATIONS)
        assert "mood" not in [row[1] for row in connection.execute("PRAGMA table_info(episodes)")]


def _add_many(path, count):
    store = SolutionStore(path)
    for k in range(count):
        store.add(episode(text=f"{os.getpid()} {k}"))


@pytest.mark.integration
def test_processes_that_write_at_once_lose_nothing(path):
    context = multiprocessing.get_context("fork")
    writers = [context.Process(target=_add_many, args=(path, 40)) for _ in range(3)]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join(60)
    assert [writer.exitcode for writer in writers] == [0, 0, 0]
    assert len(set(texts(path))) == 120


@pytest.mark.release
@pytest.mark.integration
def test_store_process_killed_while_writing_leaves_valid_file(path):
    """After a process is killed while it writes, the file passes SQLite's check and has every reported entry."""
    code = (
        "import sys; sys.path[:0] = [{here!r}, {core!r}]\n"
        "from pathlib import Path\nfrom remembering import episode\n"
        "from stucksolver_passenger.memory import SolutionStore\n"
        "store = SolutionStore(Path({path!r}))\nwhile True: print(store.add(episode(text='x' * 500)), flush=True)"
    )
    here = os.path.dirname(__file__)
    code = code.format(here=here, core=os.path.join(here, "..", "..", "..", "stucksolver", "tests"), path=str(path))
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as writer:
        assert writer.stdout is not None
        told = [writer.stdout.readline() for _ in range(20)]
        time.sleep(0.02)
        writer.send_signal(signal.SIGKILL)
        told += writer.stdout.readlines()
    known = max(int(line) for line in told if line.strip())
    assert len(SolutionStore(path).episodes()) >= known
    with sqlite3.connect(path) as connection:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
