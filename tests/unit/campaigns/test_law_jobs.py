"""A law confirmed and asked of several campaigns, as the service's jobs compute it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rigctl.errors import AnalysisInputError
from rigctl.measuring.measured import request
from rigctl.model.computing import propose_job
from simulators.challenge import write_challenge

LAW, SHOTS = {"restitution-bump": 0.008}, 60
LIMITS = {"limits": [[5.0, 100.0], [0.0, 25.0]]}


@pytest.fixture(scope="module")
def campaigns(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of campaigns: two whose e has a bump at 5 m/s, and one without."""
    folder = tmp_path_factory.mktemp("campaigns")
    write_challenge(folder / "first", LAW, seed=3, shots=SHOTS)
    write_challenge(folder / "second", LAW, seed=4, shots=SHOTS)
    write_challenge(folder / "plain", {}, seed=5, shots=SHOTS)
    return folder


@pytest.fixture(scope="module")
def form(campaigns: Path) -> dict[str, Any]:
    """Return the form that is proposed for the first."""
    [one] = done(campaigns, "first")["proposals"]
    assert (one["slot"], one["argument"]) == ("e", "speed_n")
    found: dict[str, Any] = one["form"]
    return found


def done(campaigns: Path, name: str, **more: Any) -> dict[str, Any]:
    asked = {**request(name, []), "folder": str(campaigns / name), **LIMITS, **more}
    return propose_job(asked, lambda text, share: None)


def test_the_form_of_an_answer_is_confirmed_where_it_holds_and_not_where_it_does_not(
    campaigns: Path, form: dict[str, Any]
) -> None:
    there = done(campaigns, "second", confirm=form)
    assert (there["confirmed"], there["used"]) == (True, SHOTS)
    assert abs(there["parameters"]["a"]["value"] - 0.008) < 5 * there["parameters"]["a"]["sigma"]
    assert done(campaigns, "plain", confirm=form)["p_value"] > 1e-4


def test_shots_that_a_form_was_chosen_on_do_not_confirm_it(
    campaigns: Path, form: dict[str, Any]
) -> None:
    with pytest.raises(AnalysisInputError, match="0 shots of these did not take part"):
        done(campaigns, "first", confirm=form)


def test_what_is_no_form_is_refused_with_what_is_wrong(
    campaigns: Path, form: dict[str, Any]
) -> None:
    odd = {**form, "columns": ["__import__('os').getcwd()"]}
    with pytest.raises(AnalysisInputError, match="states no form of e: columns"):
        done(campaigns, "second", confirm=odd)


@pytest.mark.long
def test_campaigns_asked_together_share_their_law(campaigns: Path) -> None:
    other = {**request("second", []), "folder": str(campaigns / "second")}
    found = done(campaigns, "first", together=[other])
    assert found["campaigns"] == ["first", "second"]
    first = found["shared"][0]
    assert (first["slot"], first["argument"]) == ("e", "speed_n")
