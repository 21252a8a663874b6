"""Output that waits in a temporary file."""

from __future__ import annotations

import errno
import io
import json
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigctl.cli import spool
from rigctl.cli.spool import Spool, print_document
from rigctl.errors import StoreError

LINES = st.lists(st.text(st.characters(exclude_characters="\n\r", exclude_categories=["Cs"])))


@given(LINES)
def test_lines_come_back_as_they_were_added_as_often_as_wanted(lines: list[str]) -> None:
    with Spool() as kept:
        for line in lines:
            kept.add(line)
        assert list(kept.lines()) == lines
        assert list(kept.lines()) == lines


@pytest.mark.parametrize("items", [[], [{"shot": 1}], [{"shot": 1}, {"shot": 2, "e": None}]])
@pytest.mark.parametrize("tail", [None, {"changes": []}])
def test_a_list_that_waited_is_part_of_one_json_document(
    items: list[object], tail: dict[str, object] | None, capsys: pytest.CaptureFixture[str]
) -> None:
    with Spool() as kept:
        for item in items:
            kept.add(json.dumps(item))
        print_document({"campaign": "nylon"}, "shots", kept, tail)
    wanted = {"campaign": "nylon", "shots": items, **(tail or {})}
    assert json.loads(capsys.readouterr().out) == wanted


def test_a_temporary_folder_that_is_full_is_named_with_what_to_do(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class Full(io.StringIO):
        def write(self, text: str) -> int:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(spool, "TemporaryFile", lambda *_, **__: Full())
    with Spool() as kept, pytest.raises(StoreError, match=r"No space left.*TMPDIR"):
        kept.add("a line")
