"""What holds for every test."""

import signal

from hypothesis import settings

# Machines are busy and noisy: how long an example takes says nothing about what is tested.
settings.register_profile("unhurried", deadline=None)
settings.load_profile("unhurried")

# A shell starts what it puts into the background with SIGINT ignored; every process that a test starts inherits that.
signal.signal(signal.SIGINT, signal.default_int_handler)
