"""The page of the configuration against the models that read it."""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Any

import pytest
from pydantic import TypeAdapter

import rigctl.config as sections
from analysis.files import FileLimits
from analysis.material import Material
from analysis.setup import Environment, SphereSetup
from rigctl.config.bench import Bench, DiskSection, StageSection
from rigctl.config.configuration import AnalysisSection, ServiceSection, Simulation
from rigctl.config.model import StrictModel
from tests.system.test_documentation import DOCS
from tests.system.test_reference_pages import rows


def literal(value: object) -> str:
    return f"`{json.dumps(value)}`"


def allowed(schema: dict[str, Any]) -> str:
    """Return in the words of the page what a field's JSON schema allows."""
    schema = next((s for s in schema.get("anyOf", []) if s.get("type") != "null"), schema)
    if "const" in schema or "enum" in schema:
        return ", ".join(map(literal, schema.get("enum", [schema.get("const")])))
    if "items" in schema:
        return f"list of {allowed(schema['items'])}"
    if schema.get("type") == "array":
        items = [allowed(item) for item in schema["prefixItems"]]
        return "two sections" if items == ["section"] * 2 else f"[{', '.join(items)}]"
    kinds = {
        "integer": "whole number",
        "number": "number",
        "string": "text",
        "boolean": "true or false",
    }
    text = kinds.get(schema.get("type", ""), "section")
    for key, sign in (("exclusiveMinimum", ">"), ("minimum", "≥"), ("maximum", "≤")):
        if key in schema:
            text += f", {sign} {Fraction(schema[key]).limit_denominator(1000)}"
    return text + (f" like `{schema['pattern']}`" if "pattern" in schema else "")


def described(model: Any) -> list[list[str]]:
    schemas = TypeAdapter(model).json_schema()["properties"]
    wanted = []
    for name, field in model.__pydantic_fields__.items():
        state = "absent" if field.default is None else "needed"
        if field.default is not None and not field.is_required():
            state = literal(field.default)
        wanted.append([f"`{name}`", allowed(schemas[name]), state])
    return sorted(wanted)


SECTIONS: dict[str, list[Any]] = {
    "Top level": [sections.Configuration],
    "[simulation]": [Simulation],
    "[limits]": [sections.Limits],
    "[trigger]": [sections.TriggerBox, sections.SolenoidPair, sections.Magnet],
    "[regulator]": [sections.Alicat],
    "[slide]": [sections.Zaber],
    "[cut_off]": [sections.Lcus],
    "[camera]": [
        sections.EktaproCamera,
        sections.V4l2Camera,
        sections.ChronosCamera,
        sections.GenicamCamera,
        sections.OwnCamera,
        sections.FilmCamera,
    ],
    "[camera.remote_trigger]": [sections.HidRelay, sections.SerialLine],
    "[camera.recorder]": [sections.EktaproLink],
    "[camera.source]": [sections.FilesSource, sections.V4l2Source],
    "[store]": [sections.StoreSection],
    "[service]": [ServiceSection],
    "[analysis]": [AnalysisSection],
    "[files]": [FileLimits],
    "[optics]": [sections.Optics],
    "[[spheres]]": [SphereSetup],
    "[environment]": [Environment],
    "[material]": [Material],
    "A stage or a disk": [Bench],
    "[stage]": [StageSection],
    "[disk]": [DiskSection],
}


@pytest.mark.parametrize("heading", SECTIONS)
def test_every_field_of_the_configuration_stands_with_its_bounds_and_default(heading: str) -> None:
    written = [row[:3] for row in rows(DOCS / "reference" / "configuration.md", heading)]
    wanted = [row for model in SECTIONS[heading] for row in described(model)]
    assert sorted(written) == sorted(wanted)


def test_every_section_of_the_configuration_has_a_heading() -> None:
    known = {model for models in SECTIONS.values() for model in models}
    exported = {getattr(sections, name) for name in sections.__all__}
    models = {m for m in exported if isinstance(m, type) and issubclass(m, StrictModel)}
    # What cameras of today have in common stands with each of them.
    assert models - {sections.FreeRateCamera} <= known
