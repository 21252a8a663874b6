"""The few calls into the kernel that a video device needs: the seam that tests replace."""

from __future__ import annotations

import fcntl
import mmap
import os
import select
from typing import Protocol


class Mapping(Protocol):
    """A mapped buffer: sliced for its bytes, closed to unmap it."""

    def __getitem__(self, place: slice, /) -> bytes:
        """Return a copy of some of its bytes."""

    def close(self) -> None:
        """Unmap it."""


class Kernel(Protocol):
    """Calls on a device node; each raises `OSError` as the system call does."""

    def open(self, path: str) -> int:
        """Open for reading and writing without blocking; return the descriptor."""

    def ioctl(self, descriptor: int, request: int, argument: bytearray) -> None:
        """Call with a buffer that the kernel reads and writes in place."""

    def map(self, descriptor: int, length: int, offset: int) -> Mapping:
        """Map a driver's buffer, shared."""

    def readable(self, descriptor: int, timeout_s: float) -> bool:
        """Wait until a filled buffer is there; False when the time is over."""

    def close(self, descriptor: int) -> None:
        """Close the descriptor."""


class LinuxKernel:
    """The system calls themselves."""

    def open(self, path: str) -> int:
        """Open for reading and writing without blocking."""
        return os.open(path, os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)

    def ioctl(self, descriptor: int, request: int, argument: bytearray) -> None:
        """Call ioctl with a mutable buffer."""
        fcntl.ioctl(descriptor, request, argument, True)

    def map(self, descriptor: int, length: int, offset: int) -> Mapping:
        """Map shared, for reading and writing as drivers expect."""
        return mmap.mmap(descriptor, length, mmap.MAP_SHARED, offset=offset)

    def readable(self, descriptor: int, timeout_s: float) -> bool:
        """Wait with select."""
        ready, _, _ = select.select([descriptor], [], [], timeout_s)
        return bool(ready)

    def close(self, descriptor: int) -> None:
        """Close the descriptor."""
        os.close(descriptor)
