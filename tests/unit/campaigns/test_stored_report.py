"""The report of a campaign in the catalogue: shots by their states, files by their hashes."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from rigctl.cli import run
from rigctl.reports.campaign import measured_results, report_job
from rigctl.reports.page import page
from rigctl.reports.source import stored_source
from rigctl.store import Change, NewShot, ShotState, Store, reading

Keep = Callable[..., list[str]]
CONFIGURATION = {"name": "simulated", "apparatus": "pusher", "sha256": "c0ffee"}


@pytest.fixture
def shots(store: Store, keep: Keep) -> list[str]:
    """Return four measured shots, and a fifth whose frames were refused."""
    names = keep(configuration=CONFIGURATION)
    pattern = store.shot(names[0])
    new = NewShot(pattern.settings, "nylon", None, "tester", True, "c0ffee", pattern.accepted_at)
    record, _ = store.accept("the fifth", "body", lambda: new)
    for state in (ShotState.FIRING, ShotState.CAPTURING, ShotState.STORED, ShotState.ANALYSING):
        store.move(record.id, state)
    why = "markers, frame 7: only 2 markers in common with frame 6"
    store.move(record.id, ShotState.REFUSED, Change(failure=why))
    return [*names, record.id]


def test_a_refused_shot_is_named_with_its_reason(store: Store, shots: list[str]) -> None:
    source = stored_source(store, "nylon")
    assert source.listed == len(shots)
    assert [(one.shot, one.reason) for one in source.missing] == [
        (
            store.shot(shots[-1]).number,
            "refused: markers, frame 7: only 2 markers in common with frame 6",
        )
    ]
    assert source.simulated


def test_results_and_manifests_are_hashed_as_they_lie_on_disk(
    store: Store, shots: list[str]
) -> None:
    files = dict(stored_source(store, "nylon").files)
    for shot in shots[:-1]:
        folder = store.folders.folder(shot)
        for name in ("manifest.json", "result-0001.json"):
            digest = hashlib.sha256((folder / name).read_bytes()).hexdigest()
            assert files[f"{shot}/{name}"] == digest
        assert files[f"{shot}/frames.npy"] == store.folders.manifest(shot)["frames"]["sha256"]


def test_configuration_spheres_and_settings_are_shown(store: Store, shots: list[str]) -> None:
    facts = {one.heading: dict(one.rows) for one in stored_source(store, "nylon").facts}
    assert facts["configuration"]["sha256"] == "c0ffee"
    assert facts["spheres 1"]["diameter_m"] == "0.0254"
    assert set(facts["settings"]) >= {"pressure_a_kpa", "offset_mm"}
    assert facts["when and by what"]["first shot accepted (UTC)"].endswith("+00:00")


@pytest.mark.long
def test_the_daemons_job_writes_what_the_command_writes(
    store: Store, shots: list[str], tmp_path: Path
) -> None:
    assert shots
    said: list[str] = []
    asked = {"store": str(store.path), "database": None, "campaign": "nylon"}
    document = report_job(asked, lambda text, _: said.append(text))
    with reading(store.path) as reader:
        source = stored_source(reader, "nylon")
    assert document == {"campaign": "nylon", "html": page(source, measured_results(source))}
    assert said == ["reading the poses", "fitting", "drawing"]
    assert '<span class="simulated">simulated</span>' in document["html"]


def test_an_imported_campaign_of_poses_alone_is_reported(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["import", str(folder), "--name", "theirs"]) == 0
    assert run(["report", "theirs", "--out", "theirs.html"]) == 0
    assert run(["report", str(folder), "--out", "ours.html"]) == 0
    theirs, ours = (Path(f"{name}.html").read_text(encoding="utf-8") for name in ("theirs", "ours"))
    numbers = re.compile(r'<div class="key">.*?</table>', re.DOTALL)
    assert numbers.findall(theirs) == numbers.findall(ours) != []
    assert "frames.npy" not in theirs
