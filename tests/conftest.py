"""What all tests share: one thread of linear algebra, no deadlines, new catalogues by replay.

Their folders lie in memory where there is room for it.
"""

from __future__ import annotations

import gc
import os
import shutil
import sys
import tempfile

import pytest

# As in every command: beside other workers more threads wait for each other, at full load. Read
# where NumPy is loaded, below.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from hypothesis import settings

from tests.replayed import replayed_migrations, statements_written_once

__all__ = ["replayed_migrations", "statements_written_once"]

# What is loaded stays: to look for garbage while it is takes an eighth of that time.
gc.disable()

MEMORY, ROOM_BYTES = "/dev/shm", 8 << 30
# Thousands of stores force what they write to disk, and wait for it half of their time. A whole run
# of all tests keeps less than a gigabyte there.
if (
    "TMPDIR" not in os.environ
    and os.access(MEMORY, os.W_OK)
    and not os.statvfs(MEMORY).f_flag & os.ST_NOEXEC
    and shutil.disk_usage(MEMORY).free > ROOM_BYTES
):
    os.environ["TMPDIR"] = MEMORY
    tempfile.tempdir = None

# An example that compiles a function takes seconds, once; each test has a time-out of its own.
settings.register_profile("compiling", deadline=None)
settings.load_profile("compiling")

NEW_MODULES = 50
"""Once a test has loaded so many, what is loaded now is put aside."""
YOUNG = 10_000
"""Look for garbage after so many new objects; the usual 700 are what one request makes."""

_put_aside = 0


def _put_aside_what_is_loaded() -> None:
    """Take what modules hold out of the collector's sight: it would look through all of it often.

    A quarter of the time of tests of the service went into that.
    """
    global _put_aside  # noqa: PLW0603 - one process, one collector
    if len(sys.modules) - _put_aside >= NEW_MODULES:
        _put_aside = len(sys.modules)
        gc.collect()
        gc.freeze()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with tests that are granted time of their own: none is left for one worker alone."""
    items.sort(key=_granted_s, reverse=True)


def _granted_s(item: pytest.Item) -> float:
    own = item.get_closest_marker("timeout")
    return float(own.args[0]) if own else 0.0


def pytest_collection_finish() -> None:
    _put_aside_what_is_loaded()
    gc.set_threshold(YOUNG)
    gc.enable()


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown() -> None:
    _put_aside_what_is_loaded()
