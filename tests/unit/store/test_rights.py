"""What a store holds is its owner's alone, whatever the umask of who writes it."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from rigctl.cameras.frames import FrameSequence
from rigctl.store import Store
from rigctl.store.integrity.copying import copy_synced


@pytest.fixture(autouse=True)
def usual_umask() -> Iterator[None]:
    before = os.umask(0o022)
    yield
    os.umask(before)


def shown(folder: Path) -> list[str]:
    """Return what others than the owner have any right to."""
    return [
        str(path.relative_to(folder))
        for path in (folder, *folder.rglob("*"))
        if stat.S_IMODE(path.stat().st_mode) & 0o077
    ]


def test_no_file_and_no_folder_of_a_store_is_open_to_others(tmp_path: Path) -> None:
    opened = Store(tmp_path / "mine" / "data")
    frames = FrameSequence(np.zeros((2, 8, 8), np.uint8), np.arange(2.0), np.arange(2), (), "test")
    opened.folders.write("20260131-000001", frames, {"shot": 1})
    opened.folders.add_result("20260131-000001", {"status": "measured"})
    opened.fits.add("nylon", "base", {"chi2": 1.0})
    (tmp_path / "given.csv").write_text("shot\n1\n")
    copy_synced(tmp_path / "given.csv", opened.path / "folder" / "shots.csv")
    opened.check()
    assert len(list(opened.path.rglob("*"))) > 8
    assert shown(opened.path) == []
    opened.close()


def test_a_store_that_was_open_to_others_is_closed_to_them(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir(mode=0o755)
    Store(tmp_path / "data").close()
    assert stat.S_IMODE((tmp_path / "data").stat().st_mode) == 0o700
