"""One set-up in the configuration, in manifests and in campaign.toml."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest

from analysis.exchange.description import description, read_description
from analysis.setup import Environment, setup_document, setup_of
from rigctl.config import default_path, load, parse
from rigctl.errors import ConfigurationError
from rigctl.measuring.stored_shot import manifest_setup

SETUP = load(None).setup
DOCUMENT = setup_document(SETUP)
FORMAT_1 = {
    "camera": {"kind": "ektapro", "rows": 192, "columns": 240, "exposure_us": 250.0},
    "picture_rate_hz": 1000.0,
    "optics": {
        "front_view_rows": [88, 192],
        "top_view_rows": [0, 88],
        "front_origin_px": [132.0, 120.0],
        "top_origin_px": None,
        "scale_px_per_m": None,
    },
    "spheres": [
        {"name": "a", "diameter_m": 0.0254, "density_kg_per_m3": 1150.0, "inertia_factor": 0.4},
        {"name": "b", "plate": True},
    ],
    "environment": {"gravity_m_per_s2": 9.81, "air_density_kg_per_m3": 1.1},
}


def test_the_set_up_of_a_configuration_reads_back_from_its_json() -> None:
    assert setup_of(json.loads(json.dumps(DOCUMENT))) == SETUP


def test_the_set_up_of_a_configuration_reads_back_from_campaign_toml(tmp_path: Path) -> None:
    path = tmp_path / "campaign.toml"
    path.write_text(description("nylon", SETUP), encoding="utf-8")
    name, found = read_description(path)
    assert (name, setup_document(found)["spheres"]) == ("nylon", DOCUMENT["spheres"])
    assert found.environment == SETUP.environment
    assert found.camera.front_view_rows == SETUP.camera.front_view_rows


def test_a_manifest_holds_the_set_up_as_one_table() -> None:
    assert manifest_setup({"format": 2, "setup": DOCUMENT}) == SETUP


def test_a_manifest_of_format_1_is_read_as_before() -> None:
    found = manifest_setup(FORMAT_1)
    assert (found.camera.height_px, found.camera.width_px) == (192, 240)
    assert found.camera.frame_rate_hz == 1000.0
    assert found.camera.exposure_s == pytest.approx(250e-6)
    assert found.camera.front_view_rows == (88, 192)
    assert found.camera.top_view_rows == (0, 88)
    assert (found.camera.front_origin_px, found.camera.top_origin_px) == ((132.0, 120.0), None)
    assert found.spheres[0].diameter_m == 0.0254
    assert found.spheres[1].plate
    assert found.environment == Environment(9.81, 1.1)


@pytest.mark.parametrize(
    ("table", "key", "value", "limit"),
    [
        ("spheres", "diameter_m", 1.1, "at most 1"),
        ("spheres", "density_kg_per_m3", 40_000.0, "at most 30000"),
        ("spheres", "inertia_factor", 0.7, "at most 0.667"),
        ("environment", "gravity_m_per_s2", 101.0, "at most 100"),
        ("environment", "air_density_kg_per_m3", -0.1, "at least 0"),
        ("environment", "drag_coefficient", 11.0, "at most 10"),
    ],
)
def test_every_document_has_the_same_limits(
    tmp_path: Path, table: str, key: str, value: float, limit: str
) -> None:
    def beyond(document: dict[str, Any]) -> dict[str, Any]:
        (document["spheres"][0] if table == "spheres" else document[table])[key] = value
        return document

    with pytest.raises(ConfigurationError) as configured:
        parse(beyond(tomllib.loads(default_path().read_text(encoding="utf-8"))), "rig.toml")
    path = tmp_path / "campaign.toml"
    whole = tomllib.loads(description("nylon", SETUP))
    path.write_text(_as_toml(beyond(whole)), encoding="utf-8")
    with pytest.raises(Exception, match=limit) as described:
        read_description(path)
    for error in (configured, described):
        assert all(word in str(error.value) for word in (key, str(value), limit))


def _as_toml(document: dict[str, Any]) -> str:
    """Return TOML by hand: each table on one line, as JSON has its values."""
    lines = []
    for name, found in document.items():
        tables = found if isinstance(found, list) else [found]
        if not isinstance(tables[0], dict):
            lines.append(f"{name} = {json.dumps(found)}")
            continue
        written = [
            "{ " + ", ".join(f"{k} = {json.dumps(v)}" for k, v in one.items()) + " }"
            for one in tables
        ]
        joined = f"[{', '.join(written)}]" if isinstance(found, list) else written[0]
        lines.append(f"{name} = {joined}")
    return "\n".join(lines) + "\n"
