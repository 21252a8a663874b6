"""How a process that analyses gives memory back to the system: not with every array.

Dask starts its workers with a setting of the C library (`MALLOC_TRIM_THRESHOLD_`) that also fixes
another at 128 KiB: every larger array, a single frame in floating point among them, is asked of
the system anew, cleared page by page, and given back at once. A shot then takes a sixth to a third
more of a processor.
"""

from __future__ import annotations

import ctypes
from functools import cache

# The parameters' numbers in malloc.h.
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
LARGEST_KEPT = 32 << 20
"""Bytes of the largest array whose memory is kept: what the GNU C library arrives at by itself,
where nobody sets it."""


@cache
def keep_memory() -> None:
    """Keep the memory of arrays for the next ones, up to 64 MiB of it in this process.

    It is a matter of time alone. Where the C library is not GNU's, nothing is done.
    """
    library = ctypes.CDLL(None)
    # As elsewhere in that library: what is free at the end of the heap may be twice as much.
    for parameter, size in ((_MMAP_THRESHOLD, LARGEST_KEPT), (_TRIM_THRESHOLD, 2 * LARGEST_KEPT)):
        if hasattr(library, "mallopt"):
            library.mallopt(parameter, size)
