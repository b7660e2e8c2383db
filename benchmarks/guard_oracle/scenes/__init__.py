"""The classes of scenes. Importing this registers them all."""

from benchmarks.guard_oracle.scenes import controls, oncoming, own_direction, people, standing  # noqa: F401
