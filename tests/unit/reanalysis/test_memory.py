"""What a worker of a cluster does with the memory of its arrays."""

from __future__ import annotations

import os
import platform
import subprocess
import sys

import pytest

FAULTS = """
import resource
import numpy as np
from rigctl.reanalysis.campaign import keep_memory
{before}
np.ones(100_000)
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(50):
    np.ones(100_000)
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


def faults(before: str) -> int:
    """Return how often a process asks for a page, started as Dask starts its workers."""
    done = subprocess.run(
        [sys.executable, "-c", FAULTS.format(before=before)],
        env={**os.environ, "MALLOC_TRIM_THRESHOLD_": "65536"},
        capture_output=True,
        check=True,
        text=True,
    )
    return int(done.stdout)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another C library")
def test_memory_of_arrays_is_kept_where_dask_would_give_it_back() -> None:
    pages = 50 * 800_000 // 4096
    assert faults("") > pages / 2
    assert faults("keep_memory()") < pages / 10
