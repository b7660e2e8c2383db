"""No test measures time: a machine may be busy."""

from hypothesis import settings

settings.register_profile("untimed")
settings.load_profile("untimed")
