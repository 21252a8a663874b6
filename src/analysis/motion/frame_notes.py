"""What the analysis of a shot left out, each reason once with the frames that it holds for."""

from __future__ import annotations

import re
from collections.abc import Sequence

OF_A_FRAME = re.compile(r"frame (\d+) (has|shows|left out)(?= |:)(.+)")
OF_SEVERAL = {"has": "have", "shows": "show"}


def gathered(notes: Sequence[str]) -> list[str]:
    """Return notes in which frames with one and the same reason are one note.

    `frame 7 shows no outline` and `frame 8 shows no outline` are `frames 7–8 show no outline`. A
    note keeps its place, several that of the first of them.
    """
    frames: dict[tuple[str, str], list[int]] = {}
    for note in notes:
        found = OF_A_FRAME.fullmatch(note)
        if found is None:
            frames.setdefault(("", note), [])
        else:
            frames.setdefault((found[2], found[3]), []).append(int(found[1]))
    return [_said(verb, rest, numbers) for (verb, rest), numbers in frames.items()]


def _said(verb: str, rest: str, frames: Sequence[int]) -> str:
    if not verb:
        return rest
    if len(frames) == 1:
        return f"frame {frames[0]} {verb}{rest}"
    numbers = ranges(frames).replace("-", "–").replace(",", ", ")
    return f"frames {numbers} {OF_SEVERAL.get(verb, verb)}{rest}"


def ranges(numbers: Sequence[int]) -> str:
    """Return whole numbers in short, `1-120,122`."""
    parts: list[list[int]] = []
    for number in sorted(set(numbers)):
        if parts and number == parts[-1][1] + 1:
            parts[-1][1] = number
        else:
            parts.append([number, number])
    return ",".join(str(a) if a == b else f"{a}-{b}" for a, b in parts)
