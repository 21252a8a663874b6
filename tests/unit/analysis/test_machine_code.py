"""A kept function is used again, until anything that is built into it changes."""

from __future__ import annotations

import json
import pickle
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
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


READY = """
import json, os, sys, traceback
import numba
numba.njit(lambda x: 2.0 * x)(1.0)
for line in sys.stdin:
    folder, *programs = json.loads(line)
    started = []
    for program in programs:
        read, write = os.pipe()
        process = os.fork()
        if process == 0:
            os.chdir(folder)
            sys.path.insert(0, folder)
            os.dup2(write, 1)
            try:
                exec(program, {})
            except Exception:
                traceback.print_exc(file=sys.stdout)
            finally:
                sys.stdout.flush()
                os._exit(0)
        os.close(write)
        started.append((process, read))
    said = [open(read).read().split() for process, read in started]
    for process, read in started:
        os.waitpid(process, 0)
    print(json.dumps(said), flush=True)
"""
"""Runs programs, each in a process of its own with the compiler loaded, which takes a second."""

Together = Callable[..., list[list[str]]]
Asked = Callable[..., list[str]]


@pytest.fixture(scope="module")
def together() -> Iterator[Together]:
    """Run programs in a folder, all at once, each in a process of its own; return their words."""
    with subprocess.Popen(
        [sys.executable, "-c", READY], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as ready:
        assert ready.stdin is not None
        assert ready.stdout is not None

        def run(folder: Path, *programs: str) -> list[list[str]]:
            print(json.dumps([str(folder), *programs]), file=ready.stdin, flush=True)
            said: list[list[str]] = json.loads(ready.stdout.readline())
            return said

        yield run
        ready.stdin.close()


@pytest.fixture
def asked(package: Path, together: Together) -> Asked:
    """Return what a program says in a process of its own."""
    return lambda program=ASK: together(package, program)[0]


def test_a_kept_function_is_used_until_a_part_in_another_file_changes(
    package: Path, asked: Asked
) -> None:
    assert asked() == ["7.0", "0"]
    assert asked() == ["7.0", "1"]
    (package / "analysis" / "room" / "inner.py").write_text(PART.format("5.0"))
    assert asked() == ["16.0", "0"]


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
    asked: Asked,
) -> None:
    assert asked(TOLD + ASK) == ["1", "2", "2", "2", "7.0", "0"]
    assert asked(TOLD + ASK) == ["7.0", "1"]


def test_a_function_that_was_never_compiled_is_not_kept() -> None:
    assert not kept_on_disk(compiled(lambda x: x + 1.0))


def test_processes_that_start_together_compile_a_function_once(
    package: Path, together: Together
) -> None:
    answers = sorted(together(package, ASK, ASK))
    assert answers == [["7.0", "0"], ["7.0", "1"]]


NUMBERED = (
    "from analysis.compiled import compiled\nfrom analysis.room.inner import inner\n\n"
    "@compiled\ndef whole(x):\n    return inner(2) + inner(5) + inner(int(x))\n"
)


def test_numbers_written_at_a_call_are_no_kinds_of_their_own(package: Path, asked: Asked) -> None:
    (package / "analysis" / "room" / "whole.py").write_text(NUMBERED)
    count = "from analysis.room.inner import inner\nprint(len(inner.signatures))\n"
    assert asked(ASK + count) == ["20.0", "0", "1"]


def test_what_was_kept_under_a_type_that_is_no_more_is_compiled_once_more(
    package: Path, asked: Asked
) -> None:
    assert asked() == ["7.0", "0"]
    (index,) = (package / "analysis" / "room").rglob("whole.whole-*.nbi")
    # A list of kept functions is the library's version, then their types: here of no module.
    version = pickle.dumps(pickle.loads(index.read_bytes()))
    index.write_bytes(version + b"cno_such_module\nAnything\n.")
    assert asked() == ["7.0", "0"]
    assert asked() == ["7.0", "1"]


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
