"""A spool is a list that lies in a file."""

from __future__ import annotations

import errno
import gc
import io
import tempfile
from pathlib import Path

import numpy as np
import pytest

from analysis.model.data import spool as spools
from analysis.model.data.spool import Spool


def test_what_is_kept_comes_back_in_order_as_often_as_wanted() -> None:
    spool = Spool(np.ndarray)
    for size in (3, 0, 1000):
        spool.append(np.arange(size))
    assert len(spool) == 3
    for _ in range(2):
        assert [part.tolist() for part in spool] == [[0, 1, 2], [], list(range(1000))]


def test_two_readers_do_not_disturb_each_other_nor_a_writer() -> None:
    spool = Spool(int)
    spool.append(1)
    spool.append(2)
    first, second = iter(spool), iter(spool)
    assert (next(first), next(second), next(first)) == (1, 1, 2)
    spool.append(3)
    assert next(second) == 2
    assert list(spool) == [1, 2, 3]


def test_a_thing_of_another_kind_is_not_handed_out() -> None:
    spool = Spool(dict)
    spool.append([1])  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="list in a spool of dict"):
        list(spool)


def test_a_spool_leaves_no_file_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    spool = Spool(int)
    spool.append(1)
    assert list(tmp_path.iterdir()) == []
    descriptor = spool._file
    del spool
    gc.collect()
    assert descriptor.closed


class SmallDisk(io.BytesIO):
    """Has room for a hundred bytes, and takes what goes in of more."""

    def write(self, written: bytes) -> int:
        room = 100 - self.tell()
        some = bytes(written)[:room]
        super().write(some)
        if len(some) < len(bytes(written)):
            raise OSError(errno.ENOSPC, "No space left on device")
        return len(some)


def test_a_full_disk_is_an_error_and_what_was_kept_is_still_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(spools, "TemporaryFile", SmallDisk)
    spool = Spool(bytes)
    spool.append(b"first")
    with pytest.raises(OSError, match="No space left"):
        spool.append(b"0" * 200)
    assert list(spool) == [b"first"]
    spool.append(b"second")
    assert list(spool) == [b"first", b"second"]
