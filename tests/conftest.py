"""What holds for every test."""

from hypothesis import settings

# Machines are busy and noisy: how long an example takes says nothing about what is tested.
settings.register_profile("unhurried", deadline=None)
settings.load_profile("unhurried")
