"""A lock on an open file, between processes, on every system; closing the file gives it back."""

from __future__ import annotations

from importlib import import_module

try:
    import fcntl
except ImportError:

    def try_lock(file: int) -> bool:
        """Take the lock; False where another process has it. `file` is open for writing."""
        # The library's type hints have it on Windows alone.
        windows = import_module("msvcrt")
        try:
            windows.locking(file, windows.LK_NBLCK, 1)
        except OSError:
            return False
        return True

else:

    def try_lock(file: int) -> bool:
        """Take the lock; False where another process has it. `file` is open for writing."""
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True
