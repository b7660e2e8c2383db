"""The classes of scenes. Importing this registers them all."""

from lab.benchmarks.guard_oracle.scenes import (  # noqa: F401
    controls,
    leaders,
    leaving,
    oncoming,
    own_direction,
    people,
    resting,
    slow,
    standing,
)
