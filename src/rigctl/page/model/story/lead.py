"""The effect that is looked at: drawing, two sentences, formula, and the slider under its plot."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from html import escape

from nicegui import ui

from analysis.model.structure.findings import ALWAYS
from analysis.model.verdict.standing import AT_THE_FLOOR
from rigctl.documents import Json
from rigctl.page.model.compare import parsed
from rigctl.page.model.effect_words import in_unit
from rigctl.page.model.story.cards import Card, card_of
from rigctl.page.model.story.errors import Unseen
from rigctl.page.model.story.plots import UNITS_OF_LOGARITHMS, dots_plot, line_plot
from rigctl.page.model.story.preview import Preview, plainest, preview
from rigctl.page.model.story.readings import sentence_of
from rigctl.page.model.story.words import channel, covariate, goes_with
from rigctl.page.model.where import apart
from rigctl.page.parts.tables import minus, with_error
from rigctl.page.parts.widgets import button, plot

FURTHEST = 2.0
"""The slider reaches so many times the best amplitude, and half of it to the other side."""
STEPS = 100
"""An arrow key moves by a hundredth; none and the best size are steps."""
PREFIXES = ((1e-4, 1e6, "µ"), (1e-1, 1e3, "m"))
"""Of seconds and metres: below a size, so many of the smaller unit, and its prefix."""


def drawing(card: Card) -> None:
    """Place the drawing of an effect; one of the user's own has none."""
    address, text = card.drawing
    if address:
        ui.html(
            f'<img src="{address}" alt="{escape(text)}" width="200" height="120" loading="lazy">',
            sanitize=False,
        ).classes("drawing")


def lead_card(
    effect: Json,
    fits: tuple[Json, Json | None],
    cell: Json,
    add: Callable[[str], None],
    wait: Callable[[], bool],
) -> None:
    """Place the card of an effect.

    Parameters
    ----------
    fits
        Without it and with it; None while the second is computed, or if it cannot be.
    cell
        Whose points are drawn.
    wait
        Shows the progress of the second fit in the slider's place; returns whether it runs.
    """
    before, after = fits
    card = card_of(effect)
    shown = plainest(before, after)
    sums = None
    points = parsed(cell["points"])
    if shown is not None and after is not None:
        cell, points, gained = shown
        sums = preview(before, after, effect["effect"], (points, gained))
    with ui.element("div").classes("lead-card").props("data-testid=lead"):
        with ui.element("div").classes("stack"):
            drawing(card)
            _said(card)
        with ui.element("div").classes("stack"):
            drawn = apart(points)
            ui.label(f"{channel(cell['channel']).capitalize()}, {goes_with(cell)}").classes(
                "strong"
            )
            with ui.element("div").classes("layers"):
                plot(dots_plot(cell, drawn))
                if sums is not None:
                    plot(line_plot(cell, drawn, (sums.x, [0.0] * len(sums.x)))).classes("over")
            ui.label("Dots: what the model lacks. Line: what it gains from this effect.").classes(
                "note"
            )
            if sums is not None:
                said = said_of(cell, sums, points["unit"], points["x_label"])
                _slider(card, effect["parameters"][0], sums, said, before)
            elif not wait():
                ui.label("These shots do not determine its size.").classes("note")
        with ui.element("div").classes("stack outcome"):
            _gauge(before)
            button(
                "Add it", lambda: add(card.effect), look="fill", testid=f"add-{card.effect}"
            ).props(f'aria-label="Add {card.title}"')
            if sums is not None:
                best = button("Set to best", lambda: None, testid="to-best")
                best.on("click", js_handler="(event) => window.toBest(event.target)")


def _said(card: Card) -> None:
    with ui.element("div").classes("title"):
        ui.html(escape(card.title), sanitize=False, tag="h4")
    with ui.element("div").classes("beside"):
        ui.label(card.where).classes("pill where")
        ui.label(card.effect).classes("pill")
    ui.label(card.what)
    ui.html(f"<b>How you notice:</b> {escape(card.notice)}", sanitize=False).classes("note")
    formula = card.formula if card.typeset else escape(card.formula)
    # A long formula is scrolled, by keys as well.
    ui.html(formula, sanitize=False).classes("typeset").props(
        'tabindex=0 role=group aria-label="formula"'
    )


def said_of(cell: Json, sums: Preview, unit: str, label: str) -> Json:
    """Return the words with which the slider describes what an amplitude changes."""
    name = cell["covariate"]
    ends = [math.exp(x) if name.startswith("ln ") else x for x in (sums.x[0], sums.x[-1])]
    in_unit_of, plain = unit_of(label), covariate(name).partition(" (")[0]
    if name in UNITS_OF_LOGARITHMS:
        in_unit_of = f" {UNITS_OF_LOGARITHMS[name]}".rstrip()
    return {
        "row": channel(cell["channel"]),
        "row_unit": unit,
        "always": name == ALWAYS,
        "ends": [f"{plain} {minus(f'{end:.3g}')}{in_unit_of}" for end in ends],
    }


def unit_of(label: str) -> str:
    """Return the unit at the end of an axis label, with a space before it; empty for none."""
    _, comma, unit = label.rpartition(", ")
    return f" {unit}" if comma else ""


def _believed(low: float, high: float, ends: Sequence[float], best: float) -> None:
    """Place the scale under the slider: the believed range of its size, and the best value."""

    def place(value: float) -> float:
        share = min(1.0, max(0.0, (value - ends[0]) / (ends[1] - ends[0])))
        return 100 * (share if best > 0 else 1 - share)

    with ui.element("div").classes("expected").props("aria-hidden=true"):
        inside = ui.element("i").classes("inside")
        left, right = sorted((place(low), place(high)))
        inside.style(f"left: {left:.1f}%; right: {100 - right:.1f}%")
        ui.element("i").classes("at-best").style(f"left: {place(best):.1f}%")


def _slider(card: Card, parameter: Json, sums: Preview, said: Json, before: Json) -> None:
    error, (factor, unit) = Unseen.of(before), shown_in(parameter, sums.best)
    ends = sorted((-0.5 * sums.best, FURTHEST * sums.best))
    step = (ends[1] - ends[0]) / STEPS
    low, high = parameter["plausible"]
    bounce = before["parameters"].get("e", {}).get("value") or 0.0
    about = {"symbol": parameter["symbol"], "unit": unit, "factor": factor, **said}
    about |= {"error_unit": error.unit, "floor": error.floor or 0.0}
    about |= {"believed": [low, high], "low": ends[0], "step": step}
    about["does"] = [sentence_of(card.effect, ends[0] + k * step, bounce) for k in range(STEPS + 1)]
    document = json.dumps({**sums.document(), **about})
    slider = ui.element("input").classes("amount")
    slider.props(
        f"type=range min={ends[0]} max={ends[1]} step={step} "
        f"dir={'ltr' if sums.best > 0 else 'rtl'} "
        f'aria-label="size of: {escape(card.title)}" data-testid=amount '
        # As a value it would be set anew with every other change of the page.
        f"data-best={sums.best} defaultValue=0"
    )
    slider.on("input", js_handler=f"(event) => window.slidePreview(event.target, {document})")
    slider.on("keydown", js_handler="(event) => window.stepSlider(event)")
    _believed(low, high, ends, sums.best)
    ui.label("Move it: the line and the error follow.").classes("effect-text")
    ui.label().classes("does")
    best = {"value": factor * sums.best, "sigma": factor * sums.sigma}
    with ui.element("div").classes("beside sizes"):
        ui.label(f"{parameter['symbol']} = 0{unit}").classes("strong amplitude")
        ui.label(f"best {with_error(best)}{unit}").classes("best")
        inside = low <= sums.best <= high
        believed = minus(f"believed from {factor * low:g} to {factor * high:g}{unit}")
        ui.label(believed).classes("note" if inside else "note fails")
    ui.label(f"{parameter['symbol']}: {parameter['meaning']}. Preview; Add fits in full.").classes(
        "note"
    )


def shown_in(parameter: Json, size: float) -> tuple[float, str]:
    """Return by what a size is multiplied to be read, and its unit with a space before it."""
    unit = in_unit(parameter)
    if parameter["unit"] in {"s", "m"}:
        for below, factor, prefix in PREFIXES:
            if abs(size) < below:
                return factor, f" {prefix}{parameter['unit']}"
    return 1.0, unit


def _gauge(before: Json) -> None:
    ui.label("error on unseen shots").classes("note")
    error = Unseen.of(before)
    level = 100 if error.floor is None or error.value > AT_THE_FLOOR else 4
    ui.html(f'<i style="height: {level}%"></i>', sanitize=False).classes("gauge").props(
        "aria-hidden=true"
    )
    ui.label(error.said()).classes("gauge-number").props("data-testid=preview-error")
    if error.floor is not None:
        ui.label("1.00 × is the floor: the noise").classes("note")
