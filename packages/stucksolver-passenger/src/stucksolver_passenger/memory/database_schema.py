"""The file's tables by version. A file of an older version is migrated when it is opened."""

from __future__ import annotations

import sqlite3

APPLICATION_ID = 0x53744D65
""""StMe": written into the file's header, so that other SQLite files are not mistaken for a memory."""
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
"""Number n leads from version n to n + 1. Only append: users' files have gone through the existing ones."""


def version_of(connection: sqlite3.Connection) -> int:
    """Return the file's version; 0 for an empty file."""
    return int(connection.execute("PRAGMA user_version").fetchone()[0])


def migrate(connection: sqlite3.Connection, migrations: tuple[str, ...] = MIGRATIONS) -> None:
    """Migrate a file, each step completely or not at all, even if another process opens it at the same time."""
    while version_of(connection) < len(migrations):
        connection.execute("BEGIN IMMEDIATE")
        try:
            # Checked again: another process may have been faster.
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
