"""The guide to effects of one's own, followed to the letter: found, measured, and faults told."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.system.test_documentation import DOCS, needs_shell, perform

pytestmark = pytest.mark.long

HIDDEN_PER_KELVIN = 0.008
"""What `reveal` says of the challenge of the guide."""


@needs_shell
@pytest.mark.timeout(600)
def test_the_guide_finds_what_no_catalogue_holds_at_its_true_size(tmp_path: Path) -> None:
    said = perform(DOCS / "how-to" / "add-your-own-effect.md", tmp_path)
    assert "unexplained - relative velocity n against temperature_c" in said
    assert f"hidden: restitution-temperature, {HIDDEN_PER_KELVIN:g} 1/K" in said
    verdict = json.loads((tmp_path / "verdict.json").read_text())
    assert (verdict["verdict"], verdict["effects"]) == ("effect", ["restitution-warmth"])
    assert verdict["faults"] == []
    size = verdict["parameters"]["restitution-warmth.a"]
    assert size["value"] == pytest.approx(HIDDEN_PER_KELVIN, abs=4 * size["sigma"])
    first, last = verdict["path"][0], verdict["path"][-1]
    assert first["prediction_error"] > 1.5
    assert last["prediction_error"] < 1.05
    [fault] = json.loads((tmp_path / "effects.json").read_text())["faults"]
    assert (fault["effect"], fault["line"]) == ("leaky", 4)
    assert "shape" in fault["what"]
