"""What all tests share: examples without a deadline, new catalogues by replay."""

from __future__ import annotations

from hypothesis import settings

from tests.replayed import replayed_migrations

__all__ = ["replayed_migrations"]

# An example that compiles a function takes seconds, once; each test has a time-out of its own.
settings.register_profile("compiling", deadline=None)
settings.load_profile("compiling")
