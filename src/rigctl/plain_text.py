"""What a line of free text may hold: notes, reasons, names and actors, wherever they come from.

Control characters break a line or a terminal; characters of direction show a text in another order
than it is stored in; what has no width cannot be seen at all. What scripts need to join letters
(U+200C, U+200D) is allowed.
"""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import StringConstraints

from rigctl.errors import SettingsError

LONGEST_LINE = 500
_HARMFUL = (
    r"\x00-\x1f\x7f-\x9f\u00ad\u061c\u200b\u200e\u200f\u2028-\u202e\u2060-\u2069\ufeff\ufff9-\ufffb"
)
PLAIN = rf"^[^{_HARMFUL}]*$"
"""Pattern of a whole text, for Python, the models and the OpenAPI document."""
_FIRST = re.compile(f"[{_HARMFUL}]")

Line = Annotated[str, StringConstraints(min_length=1, max_length=LONGEST_LINE, pattern=PLAIN)]
"""One line of text for the journal."""

_WORD = "^[A-Za-z0-9][A-Za-z0-9._-]{{0,{}}}$"
LONGEST_NAME, LONGEST_TAG, MOST_TAGS = 64, 32, 16

CampaignName = Annotated[str, StringConstraints(pattern=_WORD.format(LONGEST_NAME - 1))]
"""A campaign's name, which is also a folder's name."""

Tag = Annotated[str, StringConstraints(pattern=_WORD.format(LONGEST_TAG - 1))]
"""A word by which shots are found again."""


def require_word(
    word: str, fault: str, part: str, *, longest: int = LONGEST_NAME, todo: str | None = None
) -> str:
    """Return a word that may be a campaign's name or, with another length, a tag.

    Raises
    ------
    SettingsError
        It may not; `fault` has the reason.
    """
    if re.fullmatch(_WORD.format(longest - 1)[1:-1], word) is None:
        raise SettingsError(
            fault,
            part=part,
            value=repr(word),
            limit=f"1 to {longest} letters, digits, dots, hyphens or underscores, first a letter "
            "or digit",
            todo=todo,
        )
    return word


def require_plain(text: str | None, part: str, shot: str | None = None) -> None:
    """Refuse a text that holds what a line must not; None and an empty text are none.

    Raises
    ------
    SettingsError
        It does; with the first such character and its place.
    """
    found = None if text is None else _FIRST.search(text)
    if found is not None:
        raise SettingsError(
            "has a character that is not shown as it is stored",
            part=part,
            value=f"U+{ord(found[0]):04X} at character {found.start() + 1}",
            limit="one line without characters of control or direction",
            todo="write it without",
            shot=shot,
        )
