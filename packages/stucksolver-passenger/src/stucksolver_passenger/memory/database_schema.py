"""The file's tables by version. A file of an older version is migrated when it is opened."""

from __future__ import annotations

import sqlite3

APPLICATION_ID = 0x53744D65
""""StMe" in the file's header. It distinguishes a memory from other SQLite files."""
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
"""Migration number n leads from version n to n + 1.

Only append: existing files of users have already passed the others.
"""


def version_of(connection: sqlite3.Connection) -> int:
    """Return the file's version; 0 for an empty file."""
    return int(connection.execute("PRAGMA user_version").fetchone()[0])


def migrate(connection: sqlite3.Connection, migrations: tuple[str, ...] = MIGRATIONS) -> None:
    """Migrate a file. Each step is atomic, even if another process opens the file at the same time."""
    while version_of(connection) < len(migrations):
        connection.execute("BEGIN IMMEDIATE")
        try:
            # The version is read again inside the transaction, because another process may have migrated the
            # file meanwhile.
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
