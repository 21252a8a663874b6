"""The story of a model: cards in plain words, what leads, and a preview that agrees with fits."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np
import pytest

from analysis.model.verdict.standing import Standing, Word
from analysis.quantity import Quantity
from analysis.schema.verdict import Nuisance
from rigctl.model.known_effects import ALL_EFFECTS, effect_document
from rigctl.page.model.compare import quantity_lines
from rigctl.page.model.story.answers import fell, of_the_same
from rigctl.page.model.story.cards import HERE, card_of, in_plain
from rigctl.page.model.story.errors import Unseen
from rigctl.page.model.story.lead import turning
from rigctl.page.model.story.plots import cell_plot
from rigctl.page.model.story.points import points_of
from rigctl.page.model.story.preview import preview
from rigctl.page.model.story.words import (
    alarms_in_plain,
    cells_in_plain,
    channel,
    compared,
    covariate,
    failing,
    fails_where,
    in_words,
    looked_at,
    quantity,
    rejected_in_plain,
    where,
)

CATALOGUE = [effect_document(effect) for effect in ALL_EFFECTS]


@pytest.mark.parametrize("effect", CATALOGUE, ids=lambda effect: str(effect["effect"]))
def test_an_effect_has_a_card_in_plain_words(effect: dict[str, Any]) -> None:
    card = card_of(effect)
    if "-" in card.effect:
        assert card.effect not in f"{card.title} {card.what} {card.notice}".lower()
    assert card.what.endswith((".", "!"))
    if card.typeset:
        assert card.formula.startswith("<math")
        address, text = card.drawing
        assert (HERE / "drawings" / address.rpartition("/")[2]).is_file()
        assert text


def test_a_sentence_names_effects_as_their_cards_do_and_leaves_other_words() -> None:
    said = in_plain("With mirror-angle something is missing; restitution-warmth lowers it most.")
    assert said == (
        "With “The mirror is not at 45°” something is missing; restitution-warmth lowers it most."
    )


def test_an_effect_of_ones_own_describes_itself() -> None:
    own = {
        "effect": "restitution-warmth",
        "title": "Warm nylon",
        "stage": "contact",
        "parameters": [{"meaning": "change of e per kelvin"}],
        "formula": "e = e0 [1 + a T]",
        "gives_away": "follows the temperature",
    }
    card = card_of(own)
    assert (card.title, card.what, card.typeset) == ("Warm nylon", "change of e per kelvin.", False)


def test_why_a_shot_was_left_out_is_said_without_chi_squared() -> None:
    # Its root, as an error: of 225 it is 15.
    far = "chi-squared per degree of freedom 225 times that of the median shot"
    assert "errs 15 times as much as in a usual shot" in rejected_in_plain(far)
    assert rejected_in_plain("no frames show both spheres") == "no frames show both spheres"


def test_stated_numbers_in_doubt_are_named_as_cards_name_them_and_each_once() -> None:
    zero = Quantity(0.0, 1e-3, "rad")
    pulls = {"mirror-angle.d": -4.0, "orientation-offset.r_ax": 31.6, "orientation-offset.r_ay": 2}
    alarms = [Nuisance(name=name, stated=zero, found=zero, pull=p) for name, p in pulls.items()]
    (said,) = alarms_in_plain(alarms)
    assert "up to 32 times their stated errors off" in said
    assert "“The mirror is not at 45°”, how the spheres are turned. They" in said
    assert "offset" not in said
    assert alarms_in_plain([]) == []


def test_what_has_no_plain_word_keeps_its_own() -> None:
    assert channel({"channel": "relative velocity t"}) == "sliding speed"
    assert covariate("humidity_percent") == "humidity percent"


def test_the_worst_quantity_is_said_in_its_unit_and_in_that_of_the_noise() -> None:
    rows = [row("normal velocity", 22.4, 1e-9), row("common spin", 30.0, 0.4)]
    said = compared({"stages": [{"quantities": rows}]})
    assert "speed along the line of centres wrong by 80 mm/s: 22.4 times the noise" in said
    assert compared({"stages": [{"quantities": [row("common spin", 1.0, 0.4)]}]}).startswith(
        "Everything"
    )


def test_the_curve_of_a_preview_is_what_the_residuals_lose_and_its_error_that_of_both_fits() -> (
    None
):
    x = np.linspace(0.0, 8.0, 15)
    law = 3.0 * x - 5.0
    found = preview(
        {"prediction_error": 2.4},
        {"prediction_error": 1.0, "parameters": {"drag.Cd": {"value": 0.4, "sigma": 0.1}}},
        "drag",
        (points(x, law + 1.0), points(x, np.full(15, 1.0))),
    )
    assert found is not None
    assert np.allclose(found.curve, 3.0 * np.array(found.x) - 5.0, atol=1e-3)
    assert found.at(0.0) == pytest.approx(2.4)
    assert found.at(0.4) == pytest.approx(1.0)
    assert found.at(0.8) == pytest.approx(2.4)
    assert found.at(0.2) == pytest.approx((1.0 + (2.4**2 - 1.0) / 4) ** 0.5)


def test_an_effect_that_the_shots_do_not_determine_has_no_preview() -> None:
    after = {"prediction_error": 1.0, "parameters": {"drag.Cd": {"value": None, "sigma": None}}}
    none = points(np.array([0.0, 1.0]), np.zeros(2))
    assert preview({"prediction_error": 1.0}, after, "drag", (none, none)) is None


def points(x: np.ndarray, mean: np.ndarray) -> dict[str, Any]:
    """Return the points of one cell, which lie on their mean."""
    trend = {"x": x.tolist(), "mean": mean.tolist()}
    shots = list(range(len(x)))
    own = {"shots": shots, "frames": [-1] * len(x), "x": trend["x"], "residual": trend["mean"]}
    return {**own, "trend": trend}


def row(quantity: str, error: float, p: float) -> dict[str, Any]:
    return {
        "quantity": quantity,
        "error": error,
        "p_familywise": p,
        "size": 80.0,
        "unit": "mm/s",
    } | {"shared": True}


def test_a_constant_error_is_called_one_and_a_course_is_told_by_its_ends() -> None:
    cell = {"channel": "common spin n", "covariate": "time", "p_familywise": 1e-9}
    shots = {"unit": "mrad", "frames": [-1]}
    constant = shots | {"trend": {"mean": [16.0, 17.1, 14.4]}}
    course = shots | {"trend": {"mean": [-16.0, 0.0, 14.4]}}
    said = where(cell | {"covariate": "always"}, constant, None)
    assert "wrong in all shots alike, by +15.8 mrad on average" in said
    assert "goes wrong" not in said
    turning = where(cell, course, None)
    assert "Measured is 16 mrad below the model in the first pictures" in turning
    assert turning.endswith("14.4 mrad above the model in the last.")
    warmer = where(cell | {"covariate": "temperature_c"}, course, None)
    assert "16 mrad below the model where it is least" in warmer


def test_a_quantity_that_stands_out_at_the_floor_is_named_beside_what_all_say_together() -> None:
    rows = [row("image X", 1.79, 1e-4), row("common spin", 1.01, 0.4)]
    said = compared({"stages": [{"quantities": rows}]}, Standing(Word.FLOOR))
    assert said.startswith("Over everything together the model errs no more than the noise.")
    assert "Of 2 quantities the measured height alone stands out, by 80 mm/s: 1.79 times" in said


def test_points_after_an_effect_are_those_of_the_same_shots_and_frames_as_before() -> None:
    before = {"shots": [3, 3, 8], "frames": [1, 4, 1]}
    after = {
        "shots": [3, 3, 5, 8, 8],
        "frames": [1, 2, 1, 1, 4],
        "x": [0.1, 0.2, 0.3, 0.4, 0.5],
        "residual": [1.0, 2.0, 3.0, 4.0, 5.0],
        "sigma": [0.1, 0.1, 0.1, 0.1, 0.1],
        "unit": "mm",
    }
    same = of_the_same(after, before)
    assert same["residual"] == [1.0, 4.0]
    assert (same["shots"], same["frames"], same["unit"]) == ([3, 8], [1, 1], "mm")


def test_what_adding_an_effect_did_is_said_with_digits_that_show_it() -> None:
    def said(before: float, after: float) -> str:
        return fell("Air drag", Unseen(before, "×", 1.0), Unseen(after, "×", 1.0))

    assert "falls from 1.60 to 1.012 times the noise. The floor is 1." in said(1.6, 1.0121)
    near = said(1.0134, 1.0061)
    assert "falls from 1.013 to 1.006 times the noise. Nothing can do better" in near
    assert "stays at 1.006 times the noise: too little to tell" in said(1.0061, 1.0059)
    assert "rises from 1.30 to 1.32 times the noise: too little" in said(1.3, 1.32)


def test_an_error_in_the_unit_of_what_was_measured_is_said_to_three_figures() -> None:
    said = fell("Air drag", Unseen(1.044, "mm", None), Unseen(0.5, "mm", None))
    assert said.endswith("falls from 1.04 mm to 0.500 mm.")


def test_the_bar_of_the_error_holds_its_largest_value_anywhere_on_the_slider() -> None:
    x = np.linspace(0.0, 1.0, 9)
    after = {"prediction_error": 1.0, "parameters": {"drag.Cd": {"value": 0.4, "sigma": 0.1}}}
    found = preview({"prediction_error": 2.4}, after, "drag", (points(x, x), points(x, 0 * x)))
    assert found is not None
    most = found.most((-0.2, 0.8))
    assert most == max(found.at(size) for size in np.linspace(-0.2, 0.8, 50))


def test_where_all_shots_together_show_something_no_single_cell_is_named() -> None:
    weak = {"channel": "common spin b", "covariate": "ln v_n", "p_familywise": 0.4}
    assert fails_where([weak]) == "in all shots together"
    assert fails_where([weak | {"p_familywise": 1e-5}]) == "with approach speed"
    said = where(weak, {"unit": "rad/s", "trend": {"mean": [0.0]}}, Standing(Word.MISSING))
    assert said.startswith("No cell by itself shows what is missing: only all shots together do.")
    assert where(weak, {}, Standing(Word.FLOOR)).startswith("No error goes with anything")


def test_of_frames_it_is_said_why_the_film_shows_less() -> None:
    cell = {"channel": "relative position n", "covariate": "always", "p_familywise": 1e-9}
    frames = {"unit": "mm", "trend": {"mean": [-0.85, -0.85]}, "frames": [0, 1]}
    assert "In the film of step 1 less of it is seen" in where(cell, frames, None)
    assert "film" not in where(cell, frames | {"frames": [-1, -1]}, None)


def test_the_drawing_of_the_lens_has_its_corners_farther_out_than_its_sides() -> None:
    drawn = (HERE / "drawings" / "radial-distortion.svg").read_text("utf-8")
    left = re.findall(r'd="M([0-9.]+) ([0-9.]+)((?:L[0-9. ]+)+)"', drawn)[0]
    across = [float(left[0]), *(float(x) for x in re.findall(r"L([0-9.]+) ", left[2]))]
    # As the sentence of a positive size has it: the corners of the picture lie too far out.
    assert across[0] < across[len(across) // 2] > across[-1]


def test_a_place_is_drawn_in_mm_and_a_time_in_ms_but_a_logarithm_as_it_is() -> None:
    def drawn(label: str) -> tuple[str, float, float]:
        said = {"x_label": label, "x": [0.02], "trend": {"x": [0.01], "mean": [1.0]}}
        found = points_of({"points": json.dumps(said)})
        return found["x_label"], found["x"][0], found["trend"]["x"][0]

    assert drawn("position X in the field, m") == ("position X in the field, mm", 20.0, 10.0)
    assert drawn("time from contact, s") == ("time from contact, ms", 20.0, 10.0)
    speed = "ln(v_n / (m/s)), approach speed before contact"
    assert drawn(speed) == (speed, 0.02, 0.01)


def test_the_order_of_firing_has_its_first_and_last_shot_at_the_ends_of_the_axis() -> None:
    said = {"unit": "mm/s", "shots": [1, 2], "frames": [-1, -1], "residual": [1.0, 2.0]}
    said |= {"x_label": "order of firing, first to last", "x": [-0.5, 0.5]}
    axis = cell_plot({"covariate": "always"}, said, ([], []))["layout"]["xaxis"]
    assert (axis["tickvals"], axis["ticktext"]) == ([-0.5, 0.5], ["first shot", "last shot"])
    assert axis["title"]["text"] == "order of firing"


def test_the_line_of_a_preview_bends_nowhere_where_there_is_no_dot() -> None:
    x = np.array([0.0, 0.1, 0.2, 7.8, 7.9, 8.0])
    after = {"prediction_error": 1.0, "parameters": {"drag.Cd": {"value": 0.4, "sigma": 0.1}}}
    found = preview({"prediction_error": 2.4}, after, "drag", (points(x, x**2), points(x, 0 * x)))
    assert found is not None
    assert set(found.x) <= set(x.tolist())


def test_a_course_is_told_by_its_ends_and_by_a_dip_between_them() -> None:
    assert turning([0.5, 0.6, 0.8, 1.0]) == [0, 3]
    assert turning([0.5, -3.0, 0.8, 1.0]) == [0, 1, 3]
    assert turning([0.5, 1.01, 0.8, 1.0]) == [0, 3]


def test_a_pose_before_contact_and_one_after_it_have_names_of_their_own() -> None:
    stages = [
        {"stage": f"{when} contact", "quantities": [row("position a", error, 0.4)]}
        for when, error in (("before", 1.1), ("after", 1.4))
    ]
    assert [quantity(one) for one in failing({"stages": stages})] == [
        "place of sphere a, after contact",
        "place of sphere a, before contact",
    ]
    assert compared({"stages": stages}).endswith(
        "Highest stands the place of sphere a, after contact, at 1.4 times its noise: chance alone "
        "may do that."
    )


def test_effects_that_these_shots_do_not_tell_are_counted() -> None:
    assert looked_at({"with": []}, 33, 41) == (
        "33 of the 41 known effects that are not in the model would change something here; the "
        "others leave no trace in these shots."
    )
    later = looked_at({"with": ["lasting-contact"]}, 29, 41)
    assert later.startswith("29 of the 40 known effects")
    assert later.endswith("leave no trace in these shots, or do not go with what was added.")
    assert looked_at({"with": ["drag"]}, 40, 41).endswith("would change something here.")


SPHERES = re.compile(r"sphere [ab]\b|spheres|both\b|line of centres")


def test_of_one_sphere_on_a_plate_no_word_speaks_of_two() -> None:
    places = [row("position a", 4.7, 1e-9) | {"on_plate": True} for _ in range(2)]
    stages = [
        {"stage": f"{when} contact", "quantities": [place]}
        for when, place in zip(("before", "after"), places, strict=True)
    ]
    # Depth that one view does not show is no quantity.
    unseen = row("image Z", 0.0, 1.0) | {"degrees_of_freedom": 0.0, "on_plate": True}
    found = {"stages": [*stages, {"stage": "image", "quantities": [unseen]}]}
    assert [quantity(one) for one in failing(found)] == [
        "place of the sphere, before contact",
        "place of the sphere, after contact",
    ]
    numbers = {"count": 0, "chi2": 0.0, "floor": 0.0, "degrees_of_freedom": 0.0}
    rows = [unseen | numbers]
    (_, line) = quantity_lines({"stages": [{"stage": "image", "quantities": rows}]})
    assert line.cells[1] == ""
    for name in ("velocity", "spin", "position", "orientation"):
        for axis in "ntb":
            cell = {"channel": f"relative {name} {axis}", "covariate": "time", "on_plate": True}
            assert not SPHERES.search(in_words(cell))
    text = "What is left shows most in relative position n against time."
    assert "the height over the plate, with time" in cells_in_plain(text, on_plate=True)
    assert "gap between spheres" in cells_in_plain(text)


def test_step_1_is_no_surer_than_the_verdict_that_the_shots_are_too_few() -> None:
    said = compared(
        {"stages": [{"quantities": [row("position a", 4.7, 1e-9)]}]}, Standing(Word.FEW)
    )
    assert "no noise" not in said
    assert "so few do not tell" in said
