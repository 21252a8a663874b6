"""Documents of the event model: valid by its own schemas, complete, the same each time."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.results.campaign import Results
from analysis.results.impacts import LeftOut
from rigctl.cli import run
from rigctl.errors import AnalysisInputError, StoreError
from rigctl.exports.event_documents import campaign_documents, write_documents
from rigctl.reports.source import Source, folder_source

Json = dict[str, Any]


@pytest.fixture(scope="module")
def documents(source: Source, found: Results) -> list[tuple[str, Json]]:
    return list(campaign_documents(source, found))


def of(documents: list[tuple[str, Json]], kind: str) -> list[Json]:
    return [document for name, document in documents if name == kind]


def test_every_document_is_valid_by_the_schemas_of_the_event_model(
    documents: list[tuple[str, Json]],
) -> None:
    event_model: Any = pytest.importorskip("event_model")
    for kind, document in documents:
        event_model.schema_validators[event_model.DocumentNames[kind]].validate(document)
    assert documents[0][0] == "start"
    assert documents[-1][0] == "stop"


def test_events_hold_just_what_their_descriptor_announces(
    documents: list[tuple[str, Json]],
) -> None:
    described = {one["uid"]: one for one in of(documents, "descriptor")}
    start = of(documents, "start")[0]
    seen: dict[str, list[int]] = {}
    for event in of(documents, "event"):
        descriptor = described[event["descriptor"]]
        assert set(event["data"]) == set(event["timestamps"]) == set(descriptor["data_keys"])
        seen.setdefault(descriptor["name"], []).append(event["seq_num"])
    assert {one["run_start"] for one in described.values()} == {start["uid"]}
    stop = of(documents, "stop")[0]
    assert stop["num_events"] == {name: len(numbers) for name, numbers in seen.items()}
    assert all(numbers == list(range(1, len(numbers) + 1)) for numbers in seen.values())


def test_events_have_the_shots_numbers_times_and_units(
    documents: list[tuple[str, Json]], source: Source, found: Results
) -> None:
    keys = of(documents, "descriptor")[0]["data_keys"]
    assert keys["v_n_sigma"]["units"] == "m/s"
    assert keys["pressure_a_kpa"]["units"] == "kPa"
    events = [event for event in of(documents, "event") if "e" in event["data"]]
    assert [event["time"] for event in events] == sorted(event["time"] for event in events)
    for event in events:
        shot = event["data"]["shot"]
        row = int(np.flatnonzero(found.impacts.shots == shot)[0])
        assert event["data"]["e"] == found.ratios.e.value[row]
        assert event["time"] == source.fired[shot].timestamp()


def test_identifiers_follow_from_what_was_measured(
    documents: list[tuple[str, Json]], source: Source, found: Results
) -> None:
    assert list(campaign_documents(source, found)) == documents
    names = [one["uid"] for _, one in documents]
    assert len(set(names)) == len(names)
    other = replace(source, missing=(LeftOut(7, "a hair"),))
    assert not set(names) & {one["uid"] for _, one in campaign_documents(other, found)}


def test_a_shot_without_surface_velocities_stands_in_the_first_stream_alone(
    source: Source, found: Results
) -> None:
    velocities = found.impacts.velocities.copy()
    velocities[0, 1] = np.nan
    blind = replace(found, impacts=replace(found.impacts, velocities=velocities))
    stop = of(list(campaign_documents(source, blind)), "stop")[0]
    assert stop["num_events"]["surface"] == stop["num_events"]["primary"] - 1


def test_the_command_writes_a_line_a_document(
    folder: Path, tmp_path: Path, documents: list[tuple[str, Json]]
) -> None:
    file = tmp_path / "nylon.jsonl"
    assert run(["export-events", str(folder), str(file)]) == 0
    read = [tuple(json.loads(line)) for line in file.read_text().splitlines()]
    assert read == [(kind, json.loads(json.dumps(one))) for kind, one in documents]


def test_a_file_that_is_there_is_kept(tmp_path: Path, source: Source, found: Results) -> None:
    path = tmp_path / "old.jsonl"
    path.write_text("old")
    with pytest.raises(StoreError, match="is there already"):
        write_documents(path, source, found)
    assert path.read_text() == "old"


def test_a_time_without_a_zone_is_utc(folder: Path, tmp_path: Path) -> None:
    place = tmp_path / "nylon"
    place.mkdir()
    for file in folder.glob("*.*"):
        (place / file.name).write_bytes(file.read_bytes())
    text = (place / "shots.csv").read_text()
    naive = re.sub(r"(T\d\d:\d\d:\d\d[.\d]*)(Z|\+00:00)", r"\1", text)
    assert naive != text
    (place / "shots.csv").write_text(naive)
    assert folder_source(place).fired == folder_source(folder).fired


def test_a_shot_without_a_time_is_refused_by_number(source: Source, found: Results) -> None:
    with pytest.raises(AnalysisInputError, match="shot 1: has no time"):
        list(campaign_documents(replace(source, fired={}), found))
