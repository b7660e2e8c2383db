"""Ctrl-C while a process is started: it counts afterwards, whichever thread the system gives it to."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading

import pytest

from stucksolver.interrupts import uninterrupted


def interrupt_from_another_thread() -> None:
    """As a program with worker threads meets it: the signal is not delivered to the main thread."""

    def take() -> None:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        signal.raise_signal(signal.SIGINT)

    other = threading.Thread(target=take)
    other.start()
    other.join()


def test_ctrl_c_waits_until_the_body_is_over():
    done = []
    with pytest.raises(KeyboardInterrupt), uninterrupted():
        interrupt_from_another_thread()
        done.append("the rest of the body")
    assert done == ["the rest of the body"]


def test_afterwards_ctrl_c_counts_as_before():
    with uninterrupted():
        pass
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)


def test_uninterrupted_error_restores_handler():
    """An error of the body is raised, and the signal handler is restored."""
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(OSError, match="no process"), uninterrupted():
        raise OSError("no process")
    assert signal.getsignal(signal.SIGINT) is before


def test_uninterrupted_in_other_thread_blocks_signal():
    """Ctrl-C is blocked in a thread that is not the main one, too."""
    kept = []

    def body() -> None:
        with uninterrupted():
            kept.append(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, set()))

    thread = threading.Thread(target=body)
    thread.start()
    thread.join()
    assert kept == [True]


def test_a_process_started_in_the_body_never_hears_ctrl_c():
    program = "import os, signal; os.kill(os.getpid(), signal.SIGINT); print('alive')"
    with uninterrupted():
        process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert process.communicate()[0] == "alive\n"
