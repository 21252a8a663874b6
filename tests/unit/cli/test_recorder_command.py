"""How the tape recorder's state is said."""

from __future__ import annotations

from contextlib import nullcontext
from types import SimpleNamespace

import pytest

from rigctl.cli.rig import recorder as recorder_module
from tests.invoked import rigctl


@pytest.mark.parametrize(
    ("marks", "said"), [([72], "marked at picture 72\n"), ([72, 90], "marked at pictures 72, 90\n")]
)
def test_marks_are_places_and_no_count(
    monkeypatch: pytest.MonkeyPatch, marks: list[int], said: str
) -> None:
    stands = {
        "mode": "STOP",
        "session": 1,
        "pictures": 100,
        "picture": None,
        "picture_s": None,
        "marks": marks,
        "sessions": [],
        "seconds_left": 9.0,
        "needed_s": 1.0,
        "place": "MID",
        "gamma": None,
        "erases_when_full": False,
    }
    daemon = SimpleNamespace(recorder=lambda: stands)
    monkeypatch.setattr(recorder_module, "connected", lambda *_: nullcontext(daemon))
    assert said in rigctl("recorder").stdout
