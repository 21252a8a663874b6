from types import SimpleNamespace
from typing import Any

import pytest

from rigctl.cli.rig.demo import answer_of


def told(verdict: str, *stages: tuple[str, float]) -> Any:
    """Make a verdict whose path adds each stage's effect and comes to its error; first the base."""
    names = [name for name, _ in stages]
    path = [
        SimpleNamespace(effects=tuple(names[1 : k + 1]), error=SimpleNamespace(value=error))
        for k, (_, error) in enumerate(stages)
    ]
    return SimpleNamespace(verdict=verdict, effects=tuple(names[1:]), path=path)


BASE = ("", 1.05)


@pytest.mark.parametrize(
    ("verdict", "answer"),
    [
        (told("effect", BASE, ("drag", 0.96)), ["drag"]),
        (told("alias", BASE, ("drag", 0.96), ("wind", 0.955)), ["drag"]),
        (told("alias", BASE, ("friction-speed", 1.03), ("wind", 1.028)), ["friction-speed"]),
        (told("unexplained", BASE, ("drag", 0.9)), ["drag"]),
        (told("unexplained", BASE, ("drag", 1.04)), ["unexplained"]),
        (told("none", BASE), ["none"]),
    ],
)
def test_the_answer_is_what_the_verdict_names_without_corrections_that_bring_little(
    verdict: Any, answer: list[str]
) -> None:
    assert answer_of(verdict) == answer
