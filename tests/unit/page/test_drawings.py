"""Drawings of the guide and of the effects: every arrow has its head, every word lies within."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

import rigctl.page

HERE = Path(rigctl.page.__file__).parent
DRAWINGS = sorted(HERE.glob("*/drawings/*.svg")) + sorted(HERE.glob("*/*/drawings/*.svg"))
SVG = "{http://www.w3.org/2000/svg}"
LETTER = 0.56
"""Of a letter's width in units of its height: Inter and what stands in for it are narrower."""


def parts(drawing: Path, kind: str) -> list[ET.Element]:
    root = ET.parse(drawing).getroot()
    return [one for one in root.iter() if one.tag.removeprefix(SVG) == kind]


@pytest.mark.parametrize("drawing", DRAWINGS, ids=lambda path: path.stem)
def test_every_line_that_ends_in_an_arrow_is_a_path_of_its_own(drawing: Path) -> None:
    # A head is drawn at the end of a whole path, not at that of each of its lines.
    for path in parts(drawing, "path"):
        if path.get("marker-end"):
            assert path.attrib["d"].upper().count("M") == 1


@pytest.mark.parametrize("effect", ["drag", "lasting-contact"])
def test_the_words_of_an_effect_s_drawing_lie_within_its_frame(effect: str) -> None:
    (drawing,) = [path for path in DRAWINGS if path.stem == effect]
    for text in parts(drawing, "text"):
        said = "".join(text.itertext())
        wide, x = LETTER * float(text.attrib["font-size"]) * len(said), float(text.attrib["x"])
        left = x - {"middle": wide / 2, "end": wide}.get(text.get("text-anchor", ""), 0.0)
        assert left >= 0
        assert left + wide <= 200
