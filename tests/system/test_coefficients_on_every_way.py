"""A sweep that a daemon fired, measured on every way, against the simulator's truth."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import httpx
import numpy as np
import pytest
from scipy.stats import chi2, norm

from tests.system.test_sweeps_live import RIGCTL, daemon

Found = dict[int, dict[str, tuple[float, float, float]]]
"""Of each shot and quantity: value, error, and the part of the error that is the shot's own."""
QUANTITIES = ("v_n", "v_s", "v_n_after", "v_s_after", "e", "beta")
UNIT = dict.fromkeys(QUANTITIES[:4], "_m_per_s")
SWEEP = ("--pressure-kpa", "30:60:4", "--offset-mm", "0:10:6")
WAIT_S = 1800.0
"""For one command, and for all: a bound on a hang, which a busy machine does not reach."""
ASKED_EVERY_S = 0.5
CLOCK_STEPPED = "could not be armed: clock: "
pytestmark = pytest.mark.timeout(WAIT_S)
LEAST_SHOTS = 18
CHANCE = 1e-5
"""Probability of a sound campaign beyond each bound below."""
TRUE_TO = 1.2
"""Stated errors may be too large or too small by this factor."""
FREEDOM_OF_A_SHOT = 2.6
"""Of its four velocities, whose own errors are correlated by the normal and the time of contact
that they have in common: 16 over the sum of squares of their correlations (F. E. Satterthwaite,
Biometrics Bull. 2, 110 (1946)), 2.0 to 3.4 in the shots of this sweep."""


def invoked(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*RIGCTL, *arguments],
        cwd=folder,
        env={**os.environ, "RIGCTL_KEY": ""},
        capture_output=True,
        text=True,
        timeout=WAIT_S,
        check=False,
    )


def rigctl(folder: Path, *arguments: str) -> str:
    done = invoked(folder, *arguments)
    assert done.returncode == 0, done.stderr
    return done.stdout


def fire_sweep(folder: Path) -> None:
    """Run the sweep; where the host's clock steps meanwhile, resume it as an operator does."""
    done = invoked(folder, "sweep", "run", *SWEEP, "--campaign", "nylon", "--json")
    assert done.stdout, done.stderr
    sweep, until = json.loads(done.stdout), time.monotonic() + WAIT_S
    while sweep["state"] != "completed" and time.monotonic() < until:
        if sweep["state"] == "running":
            time.sleep(ASKED_EVERY_S)
        else:
            assert sweep["state"] == "paused", sweep
            assert CLOCK_STEPPED in sweep["reason"], sweep["reason"]
            rigctl(folder, "sweep", "resume")
        sweep = json.loads(rigctl(folder, "sweep", "status", "--json"))
    assert sweep["state"] == "completed", sweep


def await_analysis(folder: Path) -> None:
    """Ask the daemon until no shot waits for its analysis.

    A command for each question would start Python each time, all the while that shots are analysed.
    """
    written = json.loads((folder / "data" / "service.json").read_text())
    until, states = time.monotonic() + WAIT_S, ["stored"]
    bearer = {"Authorization": f"Bearer {written['key']}"}
    with httpx.Client(base_url=written["url"], headers=bearer, timeout=WAIT_S) as rest:
        while {"stored", "analysing"} & set(states) and time.monotonic() < until:
            time.sleep(ASKED_EVERY_S)
            listed = rest.get("/api/v1/shots").raise_for_status().json()
            states = [shot["state"] for shot in listed["shots"]]
    assert states.count("analysed") >= LEAST_SHOTS, states


def of_report(folder: Path, campaign: str) -> Found:
    rigctl(folder, "report", campaign, "--out", "r.html", "--csv", "csv")
    with (folder / "csv" / "coefficients.csv").open() as file:
        rows = list(csv.DictReader(file))
    return {
        int(row["shot"]): {
            name: (
                float(row[name + unit]),
                float(row[f"sigma_{name}{unit}"]),
                float(row[f"sigma_own_{name}{unit}"]),
            )
            for name in QUANTITIES
            if row[name + (unit := UNIT.get(name, ""))]
        }
        for row in rows
    }


def of_json(text: str) -> Found:
    return {
        shot["shot"]: {
            name: (shot[name]["value"], shot[name]["sigma"], shot[name]["sigma_own"])
            for name in QUANTITIES
            if shot[name] is not None
        }
        for shot in json.loads(text)["shots"]
        if shot["status"] == "measured"
    }


def truth_of(folder: Path) -> dict[int, dict[str, float]]:
    [path] = folder.rglob("truth.jsonl")
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    return {
        number: {
            **{name: line[name] for name in QUANTITIES[:4]},
            "e": -line["v_n_after"] / line["v_n"],
        }
        for number, line in enumerate(lines, start=1)
        if not line["missed"]
    }


def answers(monkeypatch: pytest.MonkeyPatch, reason: str) -> list[str]:
    """Answer as a daemon whose sweep is paused once; return the orders that it is given."""
    states = iter(["paused", "running", "completed"])
    given: list[str] = []

    def answer(_: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
        given.append(arguments[1])
        shown = "resumed"
        if arguments[1] != "resume":
            shown = json.dumps({"state": next(states), "reason": reason})
        return subprocess.CompletedProcess(arguments, 3 * (arguments[1] == "run"), shown, "")

    monkeypatch.setattr(sys.modules[__name__], "invoked", answer)
    return given


def test_a_sweep_that_a_step_of_the_clock_pauses_is_resumed_and_no_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    given = answers(
        monkeypatch,
        "step 3 could not be armed: clock: 1.2 s, needed a step of at most 1 s (wall clock); "
        "check the clock of the host, then arm again",
    )
    fire_sweep(Path())
    assert given == ["run", "resume", "status", "status"]
    given = answers(monkeypatch, "step 3 could not be armed: disk: 5 MB, needed at least 100")
    with pytest.raises(AssertionError, match="disk"):
        fire_sweep(Path())
    assert given == ["run"]


@pytest.fixture(scope="module")
def ways(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Found], Path]:
    """Return what each way says of the shots of a fired sweep, and the folder of the rig."""
    folder = tmp_path_factory.mktemp("rig")
    with daemon(folder):
        fire_sweep(folder)
        await_analysis(folder)
        found = {"stored": of_report(folder, "nylon")}
        rigctl(folder, "export", "nylon", "exported")
    found["exported"] = of_report(folder, "exported")
    (folder / "exported" / "poses.csv").unlink()
    found["frames"] = of_json(rigctl(folder, "analyse", "exported", "--out", "measured", "--json"))
    (folder / "measured" / "contacts.csv").unlink()
    found["poses"] = of_report(folder, "measured")
    found["frames in a report"] = of_report(folder, "exported")
    return found, folder


def largest_difference(one: Found, other: Found) -> float:
    assert one.keys() == other.keys()
    return max(
        abs(one[shot][name][0] - other[shot][name][0]) / one[shot][name][1]
        for shot in one
        for name in one[shot].keys() & other[shot].keys()
    )


@pytest.mark.long
def test_frames_poses_and_reports_of_the_same_frames_say_the_same(
    ways: tuple[dict[str, Found], Path],
) -> None:
    found, _ = ways
    for one, other in (("frames", "poses"), ("frames", "frames in a report")):
        assert largest_difference(found[one], found[other]) < 1e-6
    assert largest_difference(found["stored"], found["exported"]) < 1e-6


def squares_about(off: np.ndarray, own: np.ndarray, common: np.ndarray) -> float:
    """Return chi-squared of errors about a common part of one unknown size."""
    shape = common / own
    size = (shape @ (off / own)) / (shape @ shape)
    return float(np.sum((off / own - size * shape) ** 2))


def bounds(freedom: float) -> tuple[float, float]:
    """Return between which chi-squared per degree of freedom of honest errors lies."""
    least, most = (float(chi2.ppf(p, freedom)) / freedom for p in (CHANCE, 1.0 - CHANCE))
    return least / TRUE_TO**2, most * TRUE_TO**2


def test_errors_stated_a_factor_of_two_wrong_lie_beyond_the_bounds() -> None:
    freedom = FREEDOM_OF_A_SHOT * 23
    least, most = bounds(freedom)
    assert chi2.sf(most / 4.0 * freedom, freedom) > 0.9
    assert chi2.cdf(least * 4.0 * freedom, freedom) > 0.7


@pytest.mark.long
@pytest.mark.parametrize("way", ["stored", "exported", "frames", "poses", "frames in a report"])
def test_every_way_is_as_near_the_truth_as_it_says(
    ways: tuple[dict[str, Found], Path], way: str
) -> None:
    found, folder = ways
    truth = {shot: own for shot, own in truth_of(folder).items() if shot in found[way]}
    assert len(truth) >= LEAST_SHOTS

    def compared(name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return errors against the truth, their pulls, and the shots' own standard errors."""
        value, sigma, alone = np.array([found[way][shot][name] for shot in truth]).T
        off = value - np.array([own[name] for own in truth.values()])
        return off, off / sigma, alone

    squares = 0.0
    for name in QUANTITIES[:4]:
        off, pulls, own = compared(name)
        assert np.abs(pulls).max() < TRUE_TO * norm.isf(CHANCE / (8 * len(truth))), name
        # Scale and drag are one draw for the campaign, and may lie far within their errors: what
        # they do to all shots is taken out.
        value = np.array([found[way][shot][name][0] for shot in truth])
        squares += squares_about(off, own, value)
    least, most = bounds(FREEDOM_OF_A_SHOT * (len(truth) - 1))
    scatter = squares / (4 * (len(truth) - 1))
    assert least < scatter < most, (len(truth), scatter)
    assert np.sqrt(np.mean(compared("e")[0] ** 2)) < 1e-3
    v_n = np.array([own["v_n"] for own in truth.values()])
    assert np.sqrt(np.mean((compared("v_n")[0] / v_n) ** 2)) < 1e-3
    assert np.sqrt(np.mean(compared("v_s")[0] ** 2)) < 5e-3
