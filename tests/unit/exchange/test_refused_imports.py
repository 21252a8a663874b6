"""A folder that cannot be imported is refused in words, and nothing of it is kept."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from rigctl.errors import AnalysisInputError, RefusedError, RigError, SettingsError, StoreError
from rigctl.exchange.importing import Imported
from rigctl.page.model.source import Source
from rigctl.settings import ShotSettings
from rigctl.store import NewShot, NewSweep, Store
from rigctl.store.imports import Imports

Take = Callable[..., Imported]


def is_untouched(store: Store) -> bool:
    shots = store.path / "shots"
    left = list(shots.iterdir()) if shots.exists() else []
    return not (left or store.shots() or store.campaigns.all() or store.edits.entries())


def append(path: Path, text: str) -> None:
    path.write_text(path.read_text() + text)


FAULTS: dict[str, tuple[Callable[[Path], object], str]] = {
    "one corrupt shot": (
        lambda f: (f / "frames" / "0003.tif").write_bytes(b"II*\0nothing"),
        r"shot 3: .*0003\.tif: damaged",
    ),
    "remarks with another key": (
        lambda f: (f / "remarks.toml").write_text('note = "cold"\nmood = "good"\n'),
        r"remarks\.toml: mood: .*found 'good'",
    ),
    "remarks with a tag of two words": (
        lambda f: (f / "remarks.toml").write_text('tags = ["two words"]\n'),
        r"remarks\.toml: tags\.0: .*found 'two words'",
    ),
    "remarks that are no TOML": (
        lambda f: (f / "remarks.toml").write_text("note = cold\n"),
        r"remarks\.toml: not TOML",
    ),
    "a frame file cut short": (
        lambda f: (f / "frames" / "0007.npy").write_bytes(
            (f / "frames" / "0007.npy").read_bytes()[:-100]
        ),
        r"shot 7: .*0007\.npy: not a whole NPY file",
    ),
    "times of other frames": (
        lambda f: (f / "frames" / "0007.json").write_text('{"times_s": [0.0]}'),
        r"shot 7: .*1 time for 6 frames",
    ),
    "frames of another depth": (
        lambda f: np.save(f / "frames" / "0007.npy", np.full((6, 16, 24), 999, np.uint32)),
        r"shot 7: .*uint32 values",
    ),
    "a later format": (
        lambda f: (f / "campaign.toml").write_text("format = 2\nname = 'x'\nlaser = true\n"),
        r"campaign\.toml: format 2; this program reads format 1",
    ),
    "no description": (lambda f: (f / "campaign.toml").unlink(), r"campaign\.toml: no such file"),
    "no shots": (lambda f: (f / "shots.csv").write_text("shot\n"), r"shots\.csv: names no shots"),
    "a line of poses that is none": (
        lambda f: append(f / "poses.csv", "3,2,soon,a,0,0,0,,,,,,,,\n"),
        r"poses\.csv, line 5: t_s: 'soon' is not a number",
    ),
    "poses of a shot that is not listed": (
        lambda f: append(f / "poses.csv", "8,0,0,a,0,0,0,,,,,,,,\n"),
        r"shots\.csv: has no line for the measured shots \[8\]",
    ),
    "a link out of the folder": (
        lambda f: (f / "elsewhere").symlink_to("/etc/passwd"),
        r"elsewhere: is neither a file nor a folder",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_folder_with_a_fault_is_refused_by_file_and_reason(
    store: Store, folder: Path, take: Take, fault: str
) -> None:
    spoil, words = FAULTS[fault]
    spoil(folder)
    with pytest.raises(AnalysisInputError, match=words) as found:
        take(folder)
    assert "nothing was imported" in found.value.sentence()
    assert is_untouched(store)


def test_one_corrupt_shot_of_five_hundred_is_named_and_nothing_is_imported(
    store: Store, folder: Path, take: Take
) -> None:
    numbers = range(1000, 1500)
    lines = "".join(f"{number}\n" for number in numbers)
    (folder / "shots.csv").write_text(f"shot\n3\n{lines}")
    for number in numbers:
        np.save(folder / "frames" / f"{number}.npy", np.zeros((1, 16, 24), np.uint8))
    (folder / "frames" / "1234.npy").write_bytes(b"nothing")
    with pytest.raises(AnalysisInputError, match=r"shot 1234: ") as found:
        take(folder)
    assert found.value.sentence().count("shot 1") == 1
    assert is_untouched(store)


def test_many_corrupt_shots_are_counted(store: Store, folder: Path, take: Take) -> None:
    (folder / "shots.csv").write_text("shot\n3\n" + "".join(f"{n}\n" for n in range(20, 30)))
    for number in range(20, 30):
        (folder / "frames" / f"{number:04d}.npy").write_bytes(b"nothing")
    with pytest.raises(AnalysisInputError, match=r"shot 20: .*shot 24: .*and 5 more"):
        take(folder)


def test_a_name_that_is_taken_is_refused(store: Store, folder: Path, take: Take) -> None:
    take(folder)
    with pytest.raises(RefusedError, match=r"there is a campaign of this name.*--name"):
        take(folder)
    assert len(store.shots()) == 3
    assert [path.name for path in (store.path / "shots").iterdir()] == ["i0001"]


def test_a_name_that_is_taken_while_files_are_kept_is_refused_at_the_end(
    store: Store, folder: Path, take: Take, monkeypatch: pytest.MonkeyPatch
) -> None:
    publish = Imports.publish

    def late(self: Imports, *arguments: object) -> None:
        with monkeypatch.context() as patched:
            patched.setattr(Imports, "publish", publish)
            take(folder)
        publish(self, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(Imports, "publish", late)
    with pytest.raises(RefusedError, match="there is a campaign of this name"):
        take(folder)
    assert len(store.shots()) == 3
    assert [path.name for path in (store.path / "shots").iterdir()] == ["i0002"]


@pytest.mark.parametrize("name", ["two words", "../up", "", "x" * 65])
def test_a_name_that_could_not_be_a_folders_is_refused(
    store: Store, folder: Path, take: Take, name: str
) -> None:
    text = (folder / "campaign.toml").read_text().replace('"nylon-2"', f'"{name or " "}"')
    (folder / "campaign.toml").write_text(text)
    with pytest.raises(SettingsError, match="name: cannot be the name"):
        take(folder)
    assert is_untouched(store)
    assert take(folder, name="fine").campaign == "fine"


def test_a_disk_that_is_full_leaves_nothing(
    store: Store, folder: Path, take: Take, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = 0

    def fsync(descriptor: int) -> None:
        nonlocal written
        written += 1
        if written == 7:
            raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(os, "fsync", fsync)
        with pytest.raises(StoreError, match=r"nothing was imported: No space left.*free"):
            take(folder)
    assert written == 7
    assert is_untouched(store)
    assert take(folder).shots == 3


def test_an_import_cut_short_between_rename_and_commit_leaves_no_campaign_and_blocks_none(
    store: Store, folder: Path, take: Take, monkeypatch: pytest.MonkeyPatch
) -> None:
    def die(_folder: Path) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr("rigctl.store.imports.sync_folder", die)
        with pytest.raises(KeyboardInterrupt):
            take(folder)
    assert store.shots() == []
    assert [path.name for path in (store.path / "shots").iterdir()] == ["i0001"]
    assert take(folder).shots == 3
    assert store.shots()[0].id == "i0002-000003"


def test_an_imported_campaign_takes_no_shots_of_this_rig(
    store: Store, folder: Path, take: Take
) -> None:
    take(folder)
    settings = ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=40.0, offset_mm=6.0)
    at = datetime(2026, 1, 31, tzinfo=UTC)

    def describe() -> NewShot:
        return NewShot(settings, "nylon-2", None, "anna", True, "c0ffee", at)

    with pytest.raises(RefusedError, match="takes no shots of this rig"):
        store.accept("key", "body", describe)
    assert store.catalogue.of_key("key") is None


def test_a_sweep_into_an_imported_campaign_is_refused_before_any_shot(
    store: Store, folder: Path, take: Take
) -> None:
    take(folder)
    settings = ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=40.0, offset_mm=6.0)
    at = datetime(2026, 1, 31, tzinfo=UTC)

    def into(campaign: str) -> NewSweep:
        return NewSweep((settings,), "{}", "{}", campaign, "anna", at)

    with pytest.raises(RefusedError, match="takes no shots of this rig; fire under another name"):
        store.sweeps.accept("key", "body", lambda: into("nylon-2"))
    assert store.sweeps.sweeps() == []
    store.sweeps.accept("key", "body", lambda: into("nylon-3"))
    assert [sweep.campaign for sweep in store.sweeps.sweeps()] == ["nylon-3"]


def test_the_page_offers_no_sweep_into_an_imported_campaign(
    store: Store, folder: Path, take: Take
) -> None:
    daemon: Any = SimpleNamespace(store=store)
    command = "rigctl model next --out"
    assert Source(daemon, "nylon-2").elsewhere(command) is None
    take(folder)
    for source in (Source(daemon, "nylon-2"), Source(daemon, "challenge", folder)):
        said = source.elsewhere(command) or ""
        assert said.startswith("for the rig that fired this campaign: rigctl model next --out")
    assert "under another name" in (Source(daemon, "nylon-2").elsewhere(command) or "")


def test_a_fault_of_the_disk_is_no_crash(store: Store, folder: Path, take: Take) -> None:
    (store.path / "shots").write_text("in the way")
    with pytest.raises(RigError):
        take(folder)
