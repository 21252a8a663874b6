"""Fits, rankings and verdicts in Python: the numbers of the commands, as tables and pictures."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import rigctl
from analysis.effects.own.template import template
from rigctl.cli import run

FOUND = ("restitution-obliquity", "torsional-friction")
PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture(scope="module")
def campaign(mystery: Path) -> rigctl.Campaign:
    return rigctl.open(mystery)


@pytest.fixture(scope="module")
def fit(campaign: rigctl.Campaign) -> rigctl.Fit:
    return campaign.fit()


def printed(capsys: pytest.CaptureFixture[str], *words: str) -> Any:
    assert run(["model", *words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_a_fit_is_that_of_the_command(
    mystery: Path, fit: rigctl.Fit, capsys: pytest.CaptureFixture[str]
) -> None:
    command = printed(capsys, "fit", str(mystery), "--with", FOUND[0])
    found = fit.add(FOUND[0]).to_dict()
    assert found == {name: value for name, value in command.items() if name != "faults"}


def test_a_ranking_is_that_of_the_command(
    mystery: Path, fit: rigctl.Fit, capsys: pytest.CaptureFixture[str]
) -> None:
    command = printed(capsys, "rank", str(mystery))
    ranking = fit.rank()
    assert ranking.to_list() == command["candidates"]
    assert ranking.best == next(iter(ranking)) == FOUND[0]
    assert len(ranking) == len(command["candidates"])
    assert ranking.p_familywise < 0.01


def test_a_verdict_is_that_of_the_command_and_says_it(
    mystery: Path, campaign: rigctl.Campaign, capsys: pytest.CaptureFixture[str]
) -> None:
    command = printed(capsys, "explain", str(mystery))
    verdict = campaign.explain()
    assert verdict.numbers == {name: value for name, value in command.items() if name != "faults"}
    assert (verdict.verdict, verdict.effects) == ("effect", FOUND)
    assert verdict.sentence.startswith(
        f"mystery: the missing effects are {FOUND[0]} and {FOUND[1]}"
    )
    assert verdict.error_path().errors == tuple(s["prediction_error"] for s in command["path"])
    assert verdict.parameters["e"].sigma > 0


def test_agreement_and_structure_are_those_of_the_command(
    mystery: Path, fit: rigctl.Fit, capsys: pytest.CaptureFixture[str]
) -> None:
    command = printed(capsys, "agreement", str(mystery))
    found = fit.agreement()
    for name in ("chi2", "stages", "prediction_error"):
        assert found.to_dict()[name] == command[name]
    assert found.prediction_error > 1.5
    assert fit.structure().to_dict() == command["structure"]
    assert fit.structure().table()["quantity"][0] == "relative velocity n"


def test_the_error_falls_to_the_noise_as_what_is_hidden_is_added(fit: rigctl.Fit) -> None:
    path = fit.add(*FOUND).error_path()
    assert path.errors[0] > path.errors[1] > path.errors[2]
    assert path.errors[2] == pytest.approx(1.0, abs=0.05)
    assert list(path.table()["with"]) == ["the base model", FOUND[0], ", ".join(FOUND)]
    assert len(fit.error_path().errors) == 1


def test_the_same_question_finds_nothing_more(fit: rigctl.Fit) -> None:
    assert fit.add(*FOUND).rank().p_familywise > 0.01
    assert fit.effects == (), "adding leaves the first fit as it was"


@pytest.mark.parametrize("way", ["file", "folder", "effect", "list"])
def test_an_effect_of_ones_own_is_fitted_in_every_form(
    mystery: Path, tmp_path: Path, way: str
) -> None:
    file = tmp_path / "my-effect.py"
    file.write_text(template("my-effect", "contact"))
    own = rigctl.effects(file)["my-effect"]
    fresh = replace(own, name="my-effect")
    if way == "folder":
        fit = rigctl.open(mystery, effects=tmp_path).fit("my-effect")
    elif way == "list":
        fit = rigctl.open(mystery, effects=[fresh]).fit("my-effect")
    else:
        fit = rigctl.open(mystery).fit(file if way == "file" else fresh)
    assert fit.effects == ("my-effect",)
    assert math.isfinite(fit.parameters["my-effect.a"].sigma)


def test_an_own_effect_is_ranked_beside_the_catalogue(mystery: Path, tmp_path: Path) -> None:
    (tmp_path / "my-effect.py").write_text(template("my-effect", "contact"))
    assert "my-effect" in list(rigctl.open(mystery, effects=tmp_path).fit().rank())


def test_an_effect_with_a_fault_is_named_and_refused(mystery: Path, tmp_path: Path) -> None:
    file = tmp_path / "my-effect.py"
    file.write_text(template("my-effect", "contact").replace("encounter.approach", "nothing"))
    with pytest.warns(UserWarning, match="left out: .*my-effect"):
        campaign = rigctl.open(mystery, effects=tmp_path)
    with pytest.raises(rigctl.AnalysisInputError, match="my-effect"):
        campaign.fit("my-effect")


def test_an_unknown_effect_is_refused_with_those_there_are(fit: rigctl.Fit) -> None:
    with pytest.raises(rigctl.NotFoundError, match=r"'tangential'.*tangential-compliance"):
        fit.add("tangential")


def test_an_own_effect_may_not_take_a_name_of_the_catalogue(fit: rigctl.Fit) -> None:
    other = replace(rigctl.effects()[FOUND[0]], title="mine")
    with pytest.raises(rigctl.AnalysisInputError, match="name of an effect of the catalogue"):
        fit.add(other)


def test_every_picture_is_axes_that_show_themselves(
    campaign: rigctl.Campaign, fit: rigctl.Fit
) -> None:
    shots = campaign.measure()
    axes = [
        *(shots.plot(of) for of in ("rebound", "restitution", "residuals")),
        fit.plot(),
        fit.rank().plot(),
        fit.error_path().plot(),
        fit.structure().plot(),
        fit.structure().plot_residuals(1),
    ]
    for one in axes:
        assert one is one.figure.axes[0]
        assert one._repr_png_()[:8] == PNG
    assert axes[0].figure._repr_png_()[:8] == PNG  # type: ignore[attr-defined]


def test_every_result_is_a_table_in_a_notebook_and_as_text(
    campaign: rigctl.Campaign, fit: rigctl.Fit
) -> None:
    for result in (fit, fit.rank(), fit.error_path(), fit.agreement(), fit.structure()):
        names = list(result.table())
        html = result._repr_html_()
        assert html.count("<th>") == len(names)
        assert "mystery" in html
        assert str(result).splitlines()[-1].strip()
    assert campaign.measure()._repr_html_().count("<tr>") == 41


def test_a_table_is_a_data_frame_where_pandas_is_installed(
    campaign: rigctl.Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "pandas.py").write_text(
        "class DataFrame(dict):\n    def __init__(self, c):\n        super().__init__(c)\n"
        "        self.attrs = {}\n"
    )
    monkeypatch.delitem(__import__("sys").modules, "pandas", raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    table: Any = campaign.measure().table()
    assert type(table).__name__ == "DataFrame"
    assert table.attrs["units"]["v_n"] == table.attrs["units"]["sigma_v_n"] == "m/s"
    assert "e" not in table.attrs["units"]
