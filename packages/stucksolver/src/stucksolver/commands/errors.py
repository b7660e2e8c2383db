"""The error of a command that cannot be run."""


class UsageError(Exception):
    """The command cannot be run like this; the message says why and what to do."""
