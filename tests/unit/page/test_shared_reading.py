from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import pytest

from rigctl.page.parts.shared_reading import read_once

BOUND_S = 20.0


def test_pages_that_ask_for_a_shot_at_the_same_moment_have_it_read_once() -> None:
    together, reads = Barrier(8), list[str]()

    def read(shot: str) -> str:
        reads.append(shot)
        return shot.upper()

    asked = read_once(read, 4)

    def ask(_: int) -> str:
        together.wait(BOUND_S)
        return asked("shot")

    with ThreadPoolExecutor(8) as threads:
        assert list(threads.map(ask, range(8), timeout=BOUND_S)) == ["SHOT"] * 8
    assert reads == ["shot"]


def test_a_failure_is_not_kept() -> None:
    answers = iter([OSError("no disk"), "frames"])

    def read(_: str) -> str:
        answer = next(answers)
        if isinstance(answer, OSError):
            raise answer
        return answer

    asked = read_once(read, 4)
    with pytest.raises(OSError, match="no disk"):
        asked("shot")
    assert asked("shot") == "frames"


def test_no_more_than_so_many_are_kept() -> None:
    reads = list[str]()
    asked = read_once(lambda shot: reads.append(shot) or shot, 2)
    for shot in ("a", "b", "c", "c", "a"):
        asked(shot)
    assert reads == ["a", "b", "c", "a"]
