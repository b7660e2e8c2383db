"""The file's tables, by version: a file of an older version is brought up to date when it is opened."""

from __future__ import annotations

import sqlite3

APPLICATION_ID = 0x53744D65
""""StMe": written into the file's header, so that other SQLite files are not taken for a memory."""
MIGRATIONS = (
    """
    CREATE TABLE episodes (
        id INTEGER PRIMARY KEY AUTOINCREMENT,
        at_s REAL NOT NULL,
        vehicle TEXT NOT NULL,
        obstacle TEXT NOT NULL,
        solution TEXT NOT NULL,
        ending TEXT NOT NULL,
        guided INTEGER NOT NULL,
        episode TEXT NOT NULL
    );
    CREATE INDEX episodes_by_obstacle ON episodes (obstacle);
    CREATE INDEX episodes_by_time ON episodes (at_s);
    """,
)
"""Number n leads from version n to n + 1. Only ever append: files of users have been through those that are here."""


def version_of(connection: sqlite3.Connection) -> int:
    """0 for an empty file."""
    return int(connection.execute("PRAGMA user_version").fetchone()[0])


def migrate(connection: sqlite3.Connection, migrations: tuple[str, ...] = MIGRATIONS) -> None:
    """Bring a file up to date, each step whole or not at all, whoever else opens it at the same time."""
    while version_of(connection) < len(migrations):
        connection.execute("BEGIN IMMEDIATE")
        try:
            # Looked at again: another process may have been quicker.
            version = version_of(connection)
            if version < len(migrations):
                for statement in filter(str.strip, migrations[version].split(";")):
                    connection.execute(statement)
                connection.execute(f"PRAGMA user_version = {version + 1}")
            connection.execute("COMMIT")
        except BaseException:
            if connection.in_transaction:
                connection.execute("ROLLBACK")
            raise
