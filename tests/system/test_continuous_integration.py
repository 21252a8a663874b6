"""The workflow file: it can be read, and runs make targets that are there; and releases."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

import rigctl
from rigctl.cli import run

ROOT = Path(__file__).parents[2]
WORKFLOW = ROOT / ".github" / "workflows" / "ci.yml"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LATER = {"benchmarks", "dev"}
"""Extras for those who work on the project: the tests and benchmarks run with them."""


@pytest.fixture(scope="module")
def jobs() -> dict[str, Any]:
    document = yaml.safe_load(WORKFLOW.read_text(encoding="utf-8"))
    # The key `on` is true in this form of YAML.
    assert document[True]["push"]["branches"] == ["main"]
    return dict(document["jobs"])


def commands(job: dict[str, Any]) -> list[str]:
    return [step["run"] for step in job["steps"] if "run" in step]


def test_every_job_ends_and_runs_what_is_there(jobs: dict[str, Any]) -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z-]+):", makefile, re.MULTILINE))
    asked = set()
    for name, job in jobs.items():
        assert job["timeout-minutes"] <= 90, name
        for line in commands(job):
            asked |= set(re.findall(r"\bmake ([a-z-]+)", line))
            for file in re.findall(r"\bpython (\S+\.py)", line):
                assert (ROOT / file).is_file(), file
    assert {"check", "test", "test-long", "wheel", "wheel-installed"} <= asked <= targets


def test_jobs_wait_for_jobs_that_there_are(jobs: dict[str, Any]) -> None:
    for job in jobs.values():
        assert job.get("needs", "wheel") in jobs


def test_every_supported_python_is_tested(jobs: dict[str, Any]) -> None:
    named = [
        line.removeprefix("Programming Language :: Python :: ") for line in PROJECT["classifiers"]
    ]
    supported = [line for line in named if line[0].isdigit()]
    assert PROJECT["requires-python"] == f">={supported[0]}"
    for name in ("tests", "wheel"):
        assert jobs[name]["strategy"]["matrix"]["python"] == supported


def test_every_extra_is_installed(jobs: dict[str, Any]) -> None:
    extras = set(PROJECT["optional-dependencies"]) - LATER
    assert set(jobs["extras"]["strategy"]["matrix"]["extra"]) == extras


def test_the_version_is_said_alike_everywhere(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--version"]) == 0
    assert capsys.readouterr().out == f"rigctl {PROJECT['version']}\n"
    assert rigctl.__version__ == PROJECT["version"]


def test_the_changelog_has_a_section_for_this_version_and_the_newest_stand_first() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    sections = re.findall(r"^## (\S+)", text, re.MULTILINE)
    if sections[0] == "Unreleased":
        del sections[0]
    assert sections[0] == PROJECT["version"]
    versions = [tuple(map(int, section.split("."))) for section in sections]
    assert versions == sorted(versions, reverse=True)
    kinds = set(re.findall(r"^### (.+)$", text, re.MULTILINE))
    assert kinds <= {"Added", "Changed", "Fixed", "Safety"}


@pytest.mark.long
def test_the_script_of_the_notebook_job_measures_what_is_filmed(tmp_path: Path) -> None:
    script = ROOT / "packaging" / "notebook.py"
    done = subprocess.run(
        [sys.executable, str(script)],
        cwd=tmp_path,
        env={**os.environ, "RIGCTL_CACHE": str(tmp_path / "cache")},
        capture_output=True,
        text=True,
        timeout=200,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "4 measured shots" in done.stdout
