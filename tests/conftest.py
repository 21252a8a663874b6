"""What all tests share: one thread of linear algebra, no deadlines, new catalogues by replay."""

from __future__ import annotations

import os

# As in every command: beside other workers more threads wait for each other, at full load. Read
# where NumPy is loaded, below.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from hypothesis import settings

from tests.replayed import replayed_migrations

__all__ = ["replayed_migrations"]

# An example that compiles a function takes seconds, once; each test has a time-out of its own.
settings.register_profile("compiling", deadline=None)
settings.load_profile("compiling")
