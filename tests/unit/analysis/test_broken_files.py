"""Files broken by chance are read or refused in one sentence; what breaks them is tried itself.

A small part of `python -m benchmarks.hostile_files`.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.hostile_files.run import Findings, run
from benchmarks.hostile_files.samples import Sample, samples


def write(sample: Sample, folder: Path) -> None:
    for name, content in ((sample.name, sample.content), *sample.beside):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)


def test_every_sample_is_read_while_it_is_whole(tmp_path: Path) -> None:
    room = tmp_path / "room"
    room.mkdir()
    for number, sample in enumerate(samples(room)):
        folder = tmp_path / str(number)
        write(sample, folder)
        sample.read(folder)


def require_faultless(findings: Findings, files: int) -> None:
    assert [f"{f.number} {f.kind} {f.outcome}: {f.words}" for f in findings.faults] == []
    assert findings.count() == files
    # Both ends are reached: what breaks files neither spares nor spoils them all.
    assert findings.count("read") > files // 20
    assert findings.count("refused") > files // 2


def test_broken_files_are_read_or_refused_in_one_sentence(tmp_path: Path) -> None:
    require_faultless(run(range(300), 2, 1, tmp_path), 300)


@pytest.mark.long
def test_many_broken_files_are_read_or_refused_in_one_sentence(tmp_path: Path) -> None:
    require_faultless(run(range(10_000), 3, 2, tmp_path), 10_000)
