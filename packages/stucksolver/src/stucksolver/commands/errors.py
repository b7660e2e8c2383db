"""Error of a command that cannot be run."""


class UsageError(Exception):
    """Command that cannot be run as given. The message has the reason and the remedy."""
