"""A kept function is used again, until anything that is built into it changes."""

from __future__ import annotations

import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import analysis
from analysis import compiled as machine_code
from analysis.compiled import compiled, kept_on_disk

PART = "from analysis.compiled import part\n\n@part\ndef inner(x):\n    return {} * x\n"
WHOLE = (
    "from analysis.compiled import compiled\nfrom analysis.room.inner import inner\n\n"
    "@compiled\ndef whole(x):\n    return inner(x) + 1.0\n"
)
ASK = (
    "from analysis.room.whole import whole\n"
    "print(whole(3.0), sum(whole.stats.cache_hits.values()))\n"
)


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A package with a compiled function in one file that calls a part in another."""
    root = tmp_path / "analysis"
    (root / "room").mkdir(parents=True)
    shutil.copy(Path(analysis.__file__).parent / "compiled.py", root)
    for folder in (root, root / "room"):
        (folder / "__init__.py").touch()
    (root / "room" / "whole.py").write_text(WHOLE)
    (root / "room" / "inner.py").write_text(PART.format("2.0"))
    return tmp_path


def asked(package: Path, program: str = ASK) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-c", program],
        check=False,
        cwd=package,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_a_kept_function_is_used_until_a_part_in_another_file_changes(package: Path) -> None:
    assert asked(package) == ["7.0", "0"]
    assert asked(package) == ["7.0", "1"]
    (package / "analysis" / "room" / "inner.py").write_text(PART.format("5.0"))
    assert asked(package) == ["16.0", "0"]


@pytest.mark.parametrize(
    "way",
    [
        "from analysis.room.numbers import FACTOR",
        "from analysis.room.numbers import (\n    FACTOR,\n)",
        "from analysis.room import numbers",
        "from analysis.room import (\n    numbers,\n)",
        "import analysis.room.numbers",
    ],
)
def test_what_is_built_in_is_all_that_is_imported_by_way_of_others_and_nothing_beside(
    package: Path, way: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    room = package / "analysis" / "room"
    monkeypatch.setattr(machine_code, "__file__", str(room.parent / "compiled.py"))

    def stamp() -> str:
        machine_code.built_in.cache_clear()
        machine_code._read.cache_clear()
        return machine_code.built_in(room / "whole.py")

    numbers, beside = room / "numbers.py", room / "beside.py"
    numbers.write_text("FACTOR = 2.0\n")
    beside.write_text(PART.format("2.0"))
    (room / "inner.py").write_text(f"{way}\n{PART.format('2.0')}")
    before = stamp()
    beside.write_text(PART.format("5.0"))
    assert stamp() == before
    numbers.write_text("FACTOR = 5.0\n")
    assert stamp() != before
    machine_code.built_in.cache_clear()
    machine_code._read.cache_clear()


TOLD = (
    "from analysis.compiled import on_compilation\n"
    "on_compilation(lambda done, of: print(done, of))\n"
)


def test_who_asks_is_told_of_each_function_that_is_compiled_and_of_none_that_was_kept(
    package: Path,
) -> None:
    assert asked(package, TOLD + ASK) == ["1", "2", "2", "2", "7.0", "0"]
    assert asked(package, TOLD + ASK) == ["7.0", "1"]


def test_a_function_that_was_never_compiled_is_not_kept() -> None:
    assert not kept_on_disk(compiled(lambda x: x + 1.0))


def test_processes_that_start_together_compile_a_function_once(package: Path) -> None:
    both = [
        subprocess.Popen(
            [sys.executable, "-c", ASK], cwd=package, stdout=subprocess.PIPE, text=True
        )
        for _ in range(2)
    ]
    answers = sorted(process.communicate(timeout=120)[0].split() for process in both)
    assert answers == [["7.0", "0"], ["7.0", "1"]]


NUMBERED = (
    "from analysis.compiled import compiled\nfrom analysis.room.inner import inner\n\n"
    "@compiled\ndef whole(x):\n    return inner(2) + inner(5) + inner(int(x))\n"
)


def test_numbers_written_at_a_call_are_no_kinds_of_their_own(package: Path) -> None:
    (package / "analysis" / "room" / "whole.py").write_text(NUMBERED)
    count = "from analysis.room.inner import inner\nprint(len(inner.signatures))\n"
    assert asked(package, ASK + count) == ["20.0", "0", "1"]


def test_what_was_kept_under_a_type_that_is_no_more_is_compiled_once_more(package: Path) -> None:
    assert asked(package) == ["7.0", "0"]
    (index,) = (package / "analysis" / "room").rglob("whole.whole-*.nbi")
    # A list of kept functions is the library's version, then their types: here of no module.
    version = pickle.dumps(pickle.loads(index.read_bytes()))
    index.write_bytes(version + b"cno_such_module\nAnything\n.")
    assert asked(package) == ["7.0", "0"]
    assert asked(package) == ["7.0", "1"]


@compiled
def row_put(table, row):
    table[0] = row


def test_a_row_of_another_length_is_refused() -> None:
    with pytest.raises(ValueError, match="shape"):
        row_put(np.zeros((2, 3)), np.zeros(4))


@compiled
def first_of(pairs):
    return pairs[0][0, 0]


@pytest.mark.parametrize("spoil", [np.asfortranarray, lambda a: a[:, ::2], np.broadcast_to])
def test_only_arrays_of_one_kind_are_taken_so_that_all_processes_round_alike(spoil) -> None:
    whole = np.ones((4, 4))
    strange = spoil(whole, (4, 4)) if spoil is np.broadcast_to else spoil(whole)
    with pytest.raises(TypeError, match="first_of takes arrays that are contiguous in rows"):
        first_of((strange, whole))
    assert first_of((whole, whole)) == 1.0
