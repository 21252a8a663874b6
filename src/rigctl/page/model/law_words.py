"""Sentences of a proposed law as the page says them: signs, buttons for options, plain names."""

from __future__ import annotations

import re

from rigctl.page.model.story.words import COVARIATES
from rigctl.page.parts.tables import RAISED

TINY = re.compile(r"\b1e(-\d+)\b")
POWER = re.compile(r"\b(\d(?:\.\d+)?)e(-\d+)\b")
NAMES = {
    "speed_n": "approach speed",
    "speed_s": "sliding speed",
    "obliquity": "sliding ÷ approach",
    **{name: COVARIATES[name].partition(" (")[0] for name in COVARIATES if "_" in name},
}
"""Of quantities that a law may depend on; those with other names are words already."""
NAMED = re.compile(rf"\b({'|'.join(sorted(NAMES, key=len, reverse=True))})\b")


def on_page(sentence: str) -> str:
    """Return a sentence with the page's signs, and its buttons in the place of options."""
    said = sentence.strip().replace("+-", "±").replace("ask with --confirm", "press Confirm")
    said = TINY.sub(lambda found: f"10{_raised(found[1])}", said)
    return POWER.sub(lambda found: f"{found[1]}·10{_raised(found[2])}", said)


def _raised(power: str) -> str:
    return str(int(power)).translate(RAISED)


def in_story(sentence: str) -> str:
    """Return the same with the names of quantities in plain words."""
    return NAMED.sub(lambda found: NAMES[found[1]], on_page(sentence))
