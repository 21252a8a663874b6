"""Pictures of the model: nothing cut off, no words over words, the same bytes every time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from analysis.effects.catalogue import CATALOGUE
from analysis.figures.agreement import agreement_figure
from analysis.figures.error_path import error_path_figure
from analysis.figures.heatmap import heatmap_figure
from analysis.figures.plane import plane_figure
from analysis.figures.ranking import alias_groups, aliases_figure, ranking_figure
from analysis.figures.residuals import residuals_figure
from analysis.figures.sheet import write
from analysis.model.agreement.agree import agree
from analysis.model.data.evidence import Stage
from analysis.model.fitting.fit import fit_campaign
from analysis.model.plane import impact_plane
from analysis.model.rank.candidate import Ranking
from analysis.model.rank.ranking import rank
from analysis.model.structure.lackoffit import deviate
from analysis.model.structure.structure import structure
from analysis.model.verdict.crossvalidation import prediction_error
from tests.unit.analysis.model.hard_spheres import campaign

NAME = "a campaign with a name that its owner thought about for a rather long while, twice"


@pytest.fixture(scope="module")
def figures() -> dict[str, Figure]:
    data = campaign(24, 85)
    covariates = {**data.covariates, "offset_mm": np.linspace(0.0, 22.0, 24)}
    data = replace(data, position=1.004 * data.position, covariates=covariates)
    fit = fit_campaign(data)
    left, ranked = structure(data, fit), rank(data, fit, CATALOGUE)
    cells = {cell.channel: cell for cell in left.cells}
    shots, frames = cells["relative velocity n"], cells["image Y"]
    path = [
        Stage(names, fit, prediction_error(data, fit))
        for names in ((), ("restitution-viscoelastic",), ("image-scale",))
    ]
    return {
        "agreement": agreement_figure(NAME, agree(data, fit)),
        "structure": heatmap_figure(NAME, left.cells),
        "shots": residuals_figure(
            NAME, shots, left.residuals("relative velocity n", shots.covariate)
        ),
        "frames": residuals_figure(NAME, frames, left.residuals("image Y", frames.covariate)),
        "ranking": ranking_figure(NAME, ranked),
        "aliases": aliases_figure(NAME, ranked),
        "rebound": plane_figure(NAME, impact_plane(data, fit)),
        "error-path": error_path_figure(NAME, path),
    }


NAMES = (
    *("agreement", "structure", "shots", "frames"),
    *("ranking", "aliases", "rebound", "error-path"),
)


def words(figure: Figure) -> list[Text]:
    """Return all texts that are drawn."""
    figure.canvas.draw()
    found = list(figure.texts)
    for axes in figure.axes:
        of_axes = set(axes.findobj(Text))
        for axis in (axes.xaxis, axes.yaxis):
            of_axes -= set(axis.findobj(Text))
            if axes.axison:
                low, high = sorted(axis.get_view_interval())
                ticks = [t for t in axis.get_major_ticks() if low <= t.get_loc() <= high]
                found += [axis.label, *(tick.label1 for tick in ticks)]
        found += of_axes
    return [text for text in found if text.get_visible() and text.get_text().strip()]


@pytest.mark.parametrize("name", NAMES)
def test_no_word_is_cut_off(name: str, figures: dict[str, Figure]) -> None:
    paper = figures[name].bbox.padded(1)
    for text in words(figures[name]):
        corners = text.get_window_extent().corners()
        assert all(paper.contains(*corner) for corner in corners), text.get_text()


@pytest.mark.parametrize("name", NAMES)
def test_no_word_stands_on_another(name: str, figures: dict[str, Figure]) -> None:
    level = [text for text in words(figures[name]) if text.get_rotation() in {0.0, 90.0}]
    boxes = [text.get_window_extent().shrunk(0.98, 0.8) for text in level]
    for i, box in enumerate(boxes):
        for j in range(i):
            assert not box.overlaps(boxes[j]), (level[i].get_text(), level[j].get_text())


@pytest.mark.parametrize("name", NAMES)
def test_every_axis_with_numbers_has_a_name_with_its_unit(
    name: str, figures: dict[str, Figure]
) -> None:
    for axes in figures[name].axes:
        if axes.axison and axes.get_xlabel():
            assert any(mark in axes.get_xlabel() for mark in "(,"), axes.get_xlabel()


def test_a_figure_is_written_as_png_and_svg_the_same_each_time(
    figures: dict[str, Figure], tmp_path: Path
) -> None:
    png, svg = write(figures["error-path"], tmp_path / "pictures", "error-path")
    picture = cv2.imread(str(png))
    assert picture is not None
    assert (picture == 255).all(axis=2).mean() > 0.5
    again = write(figures["error-path"], tmp_path / "again", "error-path")
    assert [png.read_bytes(), svg.read_bytes()] == [path.read_bytes() for path in again]


def test_a_quantity_that_fails_is_drawn_in_the_colour_of_failing(
    figures: dict[str, Figure],
) -> None:
    canvas = FigureCanvasAgg(figures["agreement"])
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())[..., :3].astype(int)
    for colour in ((0xD5, 0x5E, 0x00), (0x00, 0x72, 0xB2), (0x00, 0x9E, 0x73)):
        assert (np.abs(pixels - colour).max(axis=2) < 12).sum() > 100


def test_effects_share_a_letter_only_if_each_looks_like_each(
    ranking_of: Callable[[list[list[float]]], Ranking],
) -> None:
    chain = [[1.0, 0.95, 0.1, 0.0], [0.95, 1.0, 0.95, 0.0], [0.1, 0.95, 1.0, 0.0], [0, 0, 0, 1.0]]
    found = ranking_of(chain)
    first, second, third, fourth = (c.effect.name for c in found.candidates)
    assert alias_groups(found) == {first: "A", second: "A"}
    assert third not in alias_groups(found)
    assert fourth not in alias_groups(found)


@pytest.fixture(scope="module")
def ranking_of() -> Callable[[list[list[float]]], Ranking]:
    data = campaign(12, 86)
    ranked = rank(data, fit_campaign(data), CATALOGUE)

    def made(aliases: list[list[float]]) -> Ranking:
        seen = [c for c in ranked.candidates if c.seen][: len(aliases)]
        return replace(ranked, candidates=tuple(seen), aliases=np.array(aliases))

    return made


def test_a_chi_squared_far_beyond_the_smallest_chance_still_has_its_colour() -> None:
    assert deviate(3e3, 5) < deviate(3e4, 5)
    # 13.09 is the 97.725 per cent point of five degrees of freedom: two standard deviations.
    assert deviate(13.09, 5) == pytest.approx(2.0, abs=0.02)
    assert deviate(0.0, 0) == 0.0
