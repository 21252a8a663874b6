"""The lesson on the missing effect: its commands, its Python and the numbers it shows."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.system.test_documentation import DOCS, needs_shell, perform

LESSON = DOCS / "tutorials" / "find-the-missing-effect.md"
ENDS_WITHIN_S = 220.0
HIDDEN = ["restitution-obliquity", "torsional-friction"]

pytestmark = [needs_shell, pytest.mark.long, pytest.mark.timeout(600)]


def path_of(text: str) -> list[tuple[str, str, str]]:
    """Return the lines of an error path: effects, chi-squared, error on shots left out."""
    return re.findall(r"^ (\S.*?)  +(\d\.\d{4})  +(\d\.\d{4}) *$", text, re.MULTILINE)


@pytest.fixture(scope="module")
def lesson(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """Return the folder in which the commands were run, and what they printed.

    One test looks at all of it: two may be given to two workers, and each would run the lesson.
    """
    folder = tmp_path_factory.mktemp("lesson")
    return folder, perform(LESSON, folder)


def test_the_lesson_finds_both_effects_by_the_error_path_that_it_shows(
    lesson: tuple[Path, str],
) -> None:
    folder, said = lesson
    assert f"{' and '.join(HIDDEN)}; with" in " ".join(said.split())
    assert f"right: answered {', '.join(HIDDEN)}; the truth is {', '.join(HIDDEN)}" in said
    for picture in ("before/structure", "before/residuals-1", "after/error-path"):
        assert (folder / f"{picture}.png").stat().st_size > 10_000
    shown, printed = path_of(LESSON.read_text()), path_of(said)
    names = ["the base model", HIDDEN[0], ", ".join(HIDDEN)]
    assert [name for name, _, _ in shown] == [name for name, _, _ in printed] == names
    for (_, *claimed), (_, *found) in zip(shown, printed, strict=True):
        assert [float(x) for x in found] == pytest.approx([float(x) for x in claimed], abs=0.02)


def test_the_python_of_the_lesson_finds_the_same(lesson: tuple[Path, str]) -> None:
    (script,) = re.findall(r"^```python\n(.*?)^```$", LESSON.read_text(), re.MULTILINE | re.DOTALL)
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", script],
        cwd=lesson[0],
        capture_output=True,
        text=True,
        timeout=ENDS_WITHIN_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert [line.partition(":")[0] for line in done.stdout.splitlines()] == HIDDEN
    errors = [float(number) for number in re.findall(r"out (\d\.\d+) of", done.stdout)]
    assert errors[0] > 1.15
    assert errors[1] == pytest.approx(1.0, abs=0.03)
    assert (lesson[0] / "after" / "by-hand.png").exists()
