"""The tables of the reference and of states, against the program that they describe."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, get_args

import pytest

import rigctl.config as sections
import rigctl.service
from analysis.exchange.contact_table import CONTACTS
from analysis.exchange.pose_table import POSES
from rigctl.errors import (
    AnalysisInputError,
    CatalogueLostError,
    ConfigurationError,
    IdempotencyError,
    RigError,
)
from rigctl.jobs import JobFailedError
from rigctl.measuring.analysing import AnalysisFailedError
from rigctl.rig.states import LATCHED, TRANSITIONS
from rigctl.service.app import create_app
from rigctl.service.campaign_models import CampaignView, FitView
from rigctl.service.events import EventHub
from rigctl.service.job_models import JobView
from rigctl.service.models import InterlockView, RigEvent, RigView, ShotView
from rigctl.service.problems import Problem, from_error
from rigctl.service.routes.effects import EffectView, ParameterView
from rigctl.service.sweep_models import MeanView, StepView, SweepTable, SweepView
from rigctl.settings import ShotSettings
from rigctl.store.states import SHOT_TRANSITIONS
from rigctl.store.sweep_states import STEP_TRANSITIONS, SWEEP_TRANSITIONS
from tests import invoked
from tests.system.test_documentation import DOCS, ROOT, SWEEPS


def rows(page: Path, heading: str) -> list[list[str]]:
    """Return the cells of the tables below a heading, without their first two lines."""
    text = page.read_text(encoding="utf-8")
    part = text.partition(f"## {heading}\n")[2].partition("\n## ")[0]
    tables = re.findall(r"(?:^\|.*\n?)+", part, re.MULTILINE)
    lines = [line for table in tables for line in table.strip().splitlines()[2:]]
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]


def named(text: str) -> set[str]:
    return set(re.findall(r"`([^`]+)`", text))


def test_the_table_of_routes_is_that_of_the_openapi_document() -> None:
    daemon: Any = SimpleNamespace(configuration=sections.load(), rig=None, store=None)
    document = create_app(daemon, "key", EventHub()).openapi()
    wanted = {
        (method.upper(), f"`{path}`"): sorted(operation["responses"])
        for path, operations in document["paths"].items()
        for method, operation in operations.items()
    }
    written = {
        (method, path): sorted([*success.split(), *problems.split()])
        for method, path, success, problems in rows(DOCS / "reference/rest.md", "Routes")
    }
    assert written == wanted


def test_every_field_of_a_request_and_of_an_answer_is_named() -> None:
    text = (DOCS / "reference" / "rest.md").read_text(encoding="utf-8")
    orders = (ShotSettings, RigView, InterlockView, ShotView, RigEvent, Problem)
    questions = (CampaignView, FitView, JobView, EffectView, ParameterView)
    sweeps = (SweepView, SweepTable, StepView, MeanView)
    for model in orders + questions + sweeps:
        assert set(model.model_fields) <= named(text), model.__name__


def errors(kind: type[RigError]) -> Iterator[type[RigError]]:
    yield kind
    for below in kind.__subclasses__():
        yield from errors(below)


def codes_of_the_service() -> set[str]:
    """Return the codes that the service writes itself, read from its source."""
    folder = Path(next(iter(rigctl.service.__path__)))
    return {
        node.value.value
        for file in folder.rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.keyword) and node.arg == "code"
        if isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
    }


def test_every_problem_code_is_listed_with_its_status() -> None:
    listed = {
        code.strip("`"): status
        for code, status, _ in rows(DOCS / "reference" / "rest.md", "Problems")
    }
    elsewhere = {ConfigurationError, AnalysisInputError, AnalysisFailedError, JobFailedError}
    # The daemon does not start with it.
    elsewhere.add(CatalogueLostError)
    for kind in set(errors(RigError)) - elsewhere:
        # A missing key is found before the rig is asked, by the form of the request.
        status = 400 if kind is IdempotencyError else from_error(kind("it failed")).status
        assert listed.pop(kind.code) == str(status), kind.code
    framework = {"no-such-route", "method-not-allowed", "bad-request"}
    assert set(listed) == codes_of_the_service() | framework


def test_the_columns_of_the_exchange_tables_are_those_that_are_written() -> None:
    text = (DOCS / "reference" / "exchange-folder.md").read_text(encoding="utf-8")
    for columns in (POSES, CONTACTS):
        assert f"\n{','.join(columns)}\n" in text


FIRING = DOCS / "explanation" / "firing.md"


@pytest.mark.parametrize(
    ("page", "heading", "table"),
    [
        (FIRING, "States of the rig", TRANSITIONS),
        (FIRING, "The order of a shot, and what is on disk", SHOT_TRANSITIONS),
        (SWEEPS, "States of a sweep", SWEEP_TRANSITIONS),
        (SWEEPS, "States of a step", STEP_TRANSITIONS),
    ],
)
def test_the_tables_of_states_are_those_of_the_program(
    page: Path, heading: str, table: Any
) -> None:
    pairs = [row for row in rows(page, heading) if len(row) == 2]
    written = {
        before: set(after.split(", ")) for states, after in pairs for before in states.split(", ")
    }
    wanted = {str(before): set(map(str, after)) for before, after in table.items() if after}
    assert written == wanted


def test_the_recovery_guide_has_every_error_and_every_state_that_a_person_ends() -> None:
    guide = DOCS / "how-to" / "recover.md"
    listed = {code.strip("`") for code, *_ in rows(guide, "Errors by code")}
    assert {kind.code for kind in errors(RigError)} <= listed
    waits = {named(state).pop() for state, *_ in rows(guide, "The rig waits for a person")}
    assert waits == set(LATCHED)


def test_the_guide_to_a_real_rig_shows_every_key_of_the_recorder() -> None:
    usage = invoked.rigctl("recorder", "--help").stdout
    keys = re.search(r"One of (.*?); without one", " ".join(usage.split()))
    assert keys is not None
    text = (DOCS / "how-to" / "real-rig.md").read_text(encoding="utf-8")
    shown = set(re.findall(r"^rigctl recorder ([a-z-]+)", text, re.MULTILINE))
    assert set(keys[1].split(", ")) <= shown | {"stop"}
    assert "stop ends it" in text


def test_the_list_of_parts_has_every_section_that_names_a_device() -> None:
    listed = rows(DOCS / "how-to" / "real-rig.md", "Parts")
    assert all(len(row) == 5 for row in listed)
    text = " ".join(f"{part} {section}" for part, section, *_ in listed)
    drivers = {
        text
        for kind in (sections.TriggerBox, sections.SolenoidPair, sections.Magnet)
        for text in get_args(kind.model_fields["driver"].annotation)
    }
    assert drivers <= named(text)
    for section in ("trigger", "regulator", "slide", "cut_off", "camera"):
        assert f"[{section}]" in named(text)


def test_every_word_of_the_glossary_is_one_of_the_code() -> None:
    page = DOCS / "reference" / "glossary.md"
    table = re.findall(r"^\| (?!word |---)(.*) \| (.*) \| (.*) \|$", page.read_text(), re.MULTILINE)
    assert 20 < len(table) < 40, "one screen"
    sources = [file.read_text(encoding="utf-8") for file in (ROOT / "src").rglob("*.py")]
    words = {word for text in sources for word in re.findall(r"\w+(?:\.\w+)?", text)}
    for _, _, code in table:
        assert named(code)
        assert named(code) <= words, code
