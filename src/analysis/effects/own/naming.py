"""The form of an effect's name."""

from __future__ import annotations

import re

NAME = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
FORM = "lower case letters and figures, words joined by hyphens, as in restitution-drift"
LONGEST = 64


def well_formed(name: str) -> bool:
    """Whether a name has the form that commands, files and the API can carry."""
    return len(name) <= LONGEST and NAME.fullmatch(name) is not None
