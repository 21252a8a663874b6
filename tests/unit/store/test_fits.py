"""Saved fits: every version stays."""

from __future__ import annotations

import json
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from rigctl.errors import NotFoundError, StoreError
from rigctl.store.campaigns import Fits


@pytest.fixture
def fits(tmp_path: Path) -> Fits:
    return Fits(tmp_path)


def files(tmp_path: Path) -> list[str]:
    return sorted(path.name for path in (tmp_path / "campaigns" / "nylon" / "fits").iterdir())


def test_a_name_that_is_known_gets_a_further_version_and_the_first_stays(
    fits: Fits, tmp_path: Path
) -> None:
    assert [fits.add("nylon", "base", {"e": e}) for e in (0.7, 0.8)] == [1, 2]
    assert files(tmp_path) == ["base-0001.json", "base-0002.json"]
    assert fits.fit("nylon", "base") == (2, {"e": 0.8})
    assert fits.fit("nylon", "base", 1) == (1, {"e": 0.7})


def test_names_that_look_like_versions_are_kept_apart(fits: Fits) -> None:
    for name in ("a", "a-0001", "a-0001-0002"):
        fits.add("nylon", name, {"name": name})
    assert fits.versions("nylon") == [("a", 1), ("a-0001", 1), ("a-0001-0002", 1)]
    assert fits.fit("nylon", "a-0001") == (1, {"name": "a-0001"})


def test_versions_are_counted_beyond_four_figures(fits: Fits, tmp_path: Path) -> None:
    fits.add("nylon", "base", {})
    folder = tmp_path / "campaigns" / "nylon" / "fits"
    (folder / "base-0001.json").rename(folder / "base-9999.json")
    assert fits.add("nylon", "base", {"last": True}) == 10_000
    assert fits.fit("nylon", "base") == (10_000, {"last": True})


def test_savers_at_the_same_time_never_take_each_others_version(fits: Fits, tmp_path: Path) -> None:
    together = threading.Barrier(8, timeout=60.0)

    def save(number: int) -> int:
        together.wait()
        return fits.add("nylon", "base", {"number": number})

    with ThreadPoolExecutor(8) as pool:
        versions = list(pool.map(save, range(8)))
    assert sorted(versions) == list(range(1, 9))
    for number, version in enumerate(versions):
        assert fits.fit("nylon", "base", version) == (version, {"number": number})
    assert len(files(tmp_path)) == 8


def test_campaigns_do_not_share_fits(fits: Fits) -> None:
    fits.add("nylon", "base", {})
    assert fits.versions("brass") == []


@pytest.mark.parametrize(("name", "version"), [("other", None), ("base", 2)])
def test_a_fit_that_was_not_saved_is_not_found(fits: Fits, name: str, version: int | None) -> None:
    fits.add("nylon", "base", {})
    with pytest.raises(NotFoundError, match="campaign nylon: no such fit"):
        fits.fit("nylon", name, version)


def test_a_number_that_is_not_finite_is_refused_and_nothing_is_left(
    fits: Fits, tmp_path: Path
) -> None:
    fits.add("nylon", "base", {})
    with pytest.raises(StoreError, match="not JSON compliant"):
        fits.add("nylon", "base", {"e": float("nan")})
    assert files(tmp_path) == ["base-0001.json"]


def test_a_fit_that_cannot_be_read_is_named(fits: Fits, tmp_path: Path) -> None:
    fits.add("nylon", "base", {})
    path = tmp_path / "campaigns" / "nylon" / "fits" / "base-0001.json"
    path.write_text(json.dumps({"e": 0.7})[:-1])
    with pytest.raises(StoreError, match=r"base-0001\.json"):
        fits.fit("nylon", "base")
