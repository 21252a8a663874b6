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
from rigctl.page.model.effect_words import in_unit
from rigctl.page.model.story.cards import Card, card_of
from rigctl.page.model.story.errors import NEAR_ONE, Unseen
from rigctl.page.model.story.plots import UNITS_OF_LOGARITHMS, dots_plot, line_plot
from rigctl.page.model.story.preview import Preview, Shown, plainest, preview, size_among
from rigctl.page.model.story.where import PLACES
from rigctl.page.model.story.words import channel, covariate, goes_with
from rigctl.page.model.where import apart
from rigctl.page.parts.tables import minus, with_error
from rigctl.page.parts.widgets import button, plot

SLOW, FAST = 1.0, 8.0
"""Speeds at which a law of speed is read, m/s."""
REFERENCE = 2.0
"""At which the laws keep the fit's own coefficient, m/s."""
DEGREES = 180.0 / math.pi
FIGURES = 2
Reading = Callable[[float, float], str]
"""Sentence of an amplitude, in the parameter's own unit, and of the fit's bounce e."""


def said(value: float, unit: str = "", figures: int = FIGURES) -> str:
    """Return a number with its unit, a true minus, and no power of ten where it can be helped."""
    text = f"{value:.{figures}g}"
    if "e" in text:
        text = f"{value:.0f}" if abs(value) >= 1 else f"{value:.{figures + 5}f}".rstrip("0")
    return f"{text.rstrip('.') or '0'}{unit}".replace("-", "−")


def changed(share: float, more: str = "more", less: str = "less") -> str:
    """Return a share of change as `3 % more`."""
    return f"{said(abs(100 * share))} % {more if share >= 0 else less}"


def sentence_of(effect: str, amplitude: float, bounce: float) -> str:
    """Return what an amplitude of an effect does; empty where no sentence is known.

    Each sentence follows from the formula that the effect states, to the digits that it is read
    with; of the viscoelastic law it is the first order, exact to a hundredth of e.
    """
    reading = READINGS.get(effect)
    return "" if reading is None else f"{reading(amplitude, bounce)}."


def _viscoelastic(a: float, e: float) -> str:
    slow, fast = (e * (1 - a * (v**0.2 - REFERENCE**0.2) / 0.2) for v in (SLOW, FAST))
    return _from_to(slow, fast)


def _from_to(slow: float, fast: float) -> str:
    return (
        f"The bounce goes from {slow:.2f} at {SLOW:g} m/s to {fast:.2f} at {FAST:g} m/s"
    ).replace("-", "−")


def _powers(p: float, e: float) -> str:
    slow, fast = (min(1.0, e * (v / REFERENCE) ** -p) for v in (SLOW, FAST))
    return _from_to(slow, fast)


def _knee(p: float, e: float) -> str:
    fast = e * (FAST / REFERENCE) ** -p
    return f"The bounce stays {e:.2f} up to {REFERENCE:g} m/s and is {fast:.2f} at {FAST:g} m/s"


READINGS: dict[str, Reading] = {
    "restitution-viscoelastic": _viscoelastic,
    "restitution-plastic": _powers,
    "restitution-yield-knee": _knee,
    "restitution-obliquity": lambda a, _: f"A hit at 45° bounces {changed(a)} than a head-on one",
    "restitution-drift": lambda a, _: f"The last shot bounces {changed(a)} than the first",
    "velocity-offset": lambda u, _: (
        f"Every rebound is {said(abs(1e3 * u))} mm/s {'faster' if u >= 0 else 'slower'}"
    ),
    "adhesion": lambda a, _: (
        f"A rebound at 1 m/s {'loses' if a >= 0 else 'gains'} {said(abs(1e3 * a))} mm/s"
    ),
    "finite-contact": lambda a, _: f"The contact lasts {said(a)} times as long as Hertz says",
    "lasting-contact": lambda t, _: f"A contact at 1 m/s lasts {said(1e3 * t)} ms",
    "tangential-compliance": lambda a, _: (
        f"The skin gives {said(100 * a)} % of what elastic theory says"
    ),
    "friction-speed": lambda a, _: (
        f"Friction at 5 m/s is {changed(a * math.log(5.0))} than at 1 m/s"
    ),
    "friction-drift": lambda a, _: f"The last shot has {changed(a)} friction than the first",
    "rolling-restitution-speed": lambda a, _: (
        f"At 6 m/s {changed(a * math.log(3.0))} of the sliding comes back than at 2 m/s"
    ),
    "torsional-friction": lambda c, _: f"The contact patch is {said(2e3 * c)} mm wide at 2 m/s",
    "inertia-factor": lambda k, _: (
        f"The spheres are {changed(k, 'harder', 'easier')} to spin than solid ones; 67 % is a "
        "thin shell"
    ),
    "mass-mismatch": lambda d, _: (
        f"Sphere a is {changed(2 * d, 'heavier', 'lighter')} than sphere b"
    ),
    "drag": lambda c, _: f"Its drag coefficient is {said(c)}; a smooth sphere has 0.40 to 0.45",
    "buoyancy": lambda b, _: f"Spheres fall {said(0.16 * b)} % too slowly",
    "magnus-lift": lambda k, _: (
        f"The air pushes a spinning sphere aside {said(k)} times as hard as it does a sports ball"
    ),
    "spin-decay": lambda k, _: (
        f"The air slows the spin {said(k)} times as much as it slows a sphere that turns in still "
        "air"
    ),
    "gravity-value": lambda dg, _: f"Gravity here is {9.807 + dg:.3f} m/s²",
    "image-scale": lambda s, _: f"1 mm is measured as {1 + s:.4f} mm",
    "pixel-aspect": lambda a, _: f"Pixels are {changed(a, 'taller', 'flatter')} than wide",
    "radial-distortion": lambda k, _: (
        f"A corner of the picture lies {changed(k, 'too far out', 'too far in')}"
    ),
    "perspective": lambda q, _: (
        f"The camera stands {said(1 / q)} m from the spheres"
        if q > 0
        else "The camera stands very far away"
    ),
    "mirror-angle": lambda d, _: f"The mirror stands at {45 + DEGREES * d:.2f}°, not at 45°",
    "camera-roll": lambda s, _: f"The camera is turned by {said(DEGREES * s)}°",
    "frame-rate": lambda r, _: (
        f"The camera takes {1000 * (1 - r):.1f} pictures where 1000 are stated"
    ),
    "timing-jitter": lambda s, _: f"Pictures come {said(1e6 * s)} µs early or late",
    "exposure-offset": lambda d, _: (
        f"The outline is seen {said(abs(1e6 * d))} µs {'after' if d >= 0 else 'before'} the dots"
    ),
    "pressure-hysteresis": lambda h, _: (
        f"After a step up the spheres are {changed(h, 'faster', 'slower')}"
    ),
    "pressure-leak": lambda k, _: (
        f"After 30 s {said(100 * (1 - math.exp(-30 * k)))} % of the pressure is gone"
    ),
    "launch-delay": lambda t, _: (
        f"Valve b opens {said(abs(1e3 * t))} ms {'later' if t >= 0 else 'earlier'} than a"
    ),
    "tube-spin": lambda c, _: f"The spheres spin {said(100 * c)} % of full rolling",
}


FARTHER = 0.1
"""Of its ends' height and difference: a curve that goes farther beyond them has a peak or a dip."""
HARDLY_SEEN = 0.3
"""Of the dots' scatter: a smaller curve is hardly seen among them."""
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
    add: Callable[[str], None],
    wait: Callable[[], bool],
) -> None:
    """Place the card of an effect.

    Parameters
    ----------
    fits
        Without it and with it; None while the second is computed, or if it cannot be.
    wait
        Shows the progress of the second fit, in the place of the plot and its slider: which cell
        shows most of the effect is known with that fit. Returns whether it runs.
    """
    before, after = fits
    card = card_of(effect)
    shown = plainest(before, after, PLACES.get(card.where, ""))
    sums = None
    if shown is not None and after is not None:
        sums = preview(before, after, effect["effect"], shown[1:])
    with ui.element("div").classes("lead-card").props("data-testid=lead"):
        with ui.element("div").classes("stack"):
            drawing(card)
            _said(card)
        with ui.element("div").classes("stack"):
            if shown is not None:
                _drawn(shown, sums)
            if shown is not None and sums is not None:
                said = said_of(shown[0], sums, shown[1]["unit"], shown[1]["x_label"])
                _slider(card, effect["parameters"][0], sums, said, before)
            elif not wait():
                ui.label("These shots do not determine its size.").classes("note")
        with ui.element("div").classes("stack outcome"):
            _gauge(before, None if sums is None else sums.most(_ends(sums)))
            button(
                "Add it", lambda: add(card.effect), look="fill", testid=f"add-{card.effect}"
            ).props(f'aria-label="Add {card.title}"')
            if sums is not None:
                best = button("Set to best", lambda: None, testid="to-best")
                best.on("click", js_handler="(event) => window.toBest(event.target)")


def _drawn(shown: Shown, sums: Preview | None) -> None:
    """Place the points of a cell, with the line of the effect over them where its size is known."""
    cell, points, after = shown
    drawn = apart(points)
    ui.label(f"{channel(cell).capitalize()}, {goes_with(cell)}").classes("strong")
    with ui.element("div").classes("layers"):
        plot(dots_plot(cell, drawn, () if sums is None else sums.curve))
        if sums is not None:
            plot(line_plot(cell, drawn, sums.x, sums.curve)).classes("over")
    ui.label("Dots: what the model lacks. Line: what it gains from this effect.").classes("note")
    size = size_among(points, after)
    if sums is not None and size < HARDLY_SEEN:
        ui.label(
            f"The effect is small: here, where it shows most, it is {said(100 * size)} % of the "
            "dots' scatter. Only all shots together tell it."
        ).classes("note").props("data-testid=hardly-seen")


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
    at = turning(sums.curve)
    places = [math.exp(x) if name.startswith("ln ") else x for x in (sums.x[k] for k in at)]
    in_unit_of, plain = unit_of(label), covariate(name).partition(" (")[0]
    if name in UNITS_OF_LOGARITHMS:
        in_unit_of = f" {UNITS_OF_LOGARITHMS[name]}".rstrip()
    return {
        "row": channel(cell),
        "row_unit": unit,
        "always": name == ALWAYS,
        "told": [
            [
                k,
                _shot_said(k, sums)
                if name == "order"
                else f"{plain} {minus(f'{x:.3g}')}{in_unit_of}",
            ]
            for k, x in zip(at, places, strict=True)
        ],
    }


def _shot_said(place: int, sums: Preview) -> str:
    """Return which shot a place in the order of firing is."""
    ends = {0: "the first shot", len(sums.x) - 1: "the last shot"}
    return ends.get(place, "a shot between")


def turning(curve: Sequence[float]) -> list[int]:
    """Return the places of a curve that tell its course: both ends, and a peak or dip between."""
    last = len(curve) - 1
    ends = (curve[0], curve[last])
    room = FARTHER * (max(ends) - min(ends)) + FARTHER * max(map(abs, ends))
    away = [max(y - max(ends), min(ends) - y) for y in curve]
    most = max(range(len(curve)), key=away.__getitem__)
    return [0, most, last] if away[most] > room else [0, last]


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
    ends = _ends(sums)
    step = (ends[1] - ends[0]) / STEPS
    low, high = parameter["plausible"]
    bounce = before["parameters"].get("e", {}).get("value") or 0.0
    about = {"symbol": parameter["symbol"], "unit": unit, "factor": factor, **said}
    about |= {"error_unit": error.unit, "floor": error.floor or 0.0, "near_one": NEAR_ONE}
    about |= {"good": _good(error), "most": sums.most(ends)}
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


def _ends(sums: Preview) -> list[float]:
    """Return the least and the largest amplitude of the slider."""
    return sorted((-0.5 * sums.best, FURTHEST * sums.best))


def _good(error: Unseen) -> float:
    """Return the error up to which it is drawn as good: none where the floor is not known."""
    return 0.0 if error.floor is None else AT_THE_FLOOR


def _gauge(before: Json, most: float | None) -> None:
    """Place the error as a bar from 0 to `most`, the largest that the slider leads to."""
    ui.label("error on unseen shots").classes("note")
    error = Unseen.of(before)
    whole = most or error.value
    look = ' class="good"' if error.value <= _good(error) else ""
    drawn = f'<i{look} style="height: {100 * error.value / whole:.1f}%"></i>'
    if error.floor is not None:
        drawn += f'<b style="bottom: {100 * error.floor / whole:.1f}%"></b>'
    ui.html(drawn, sanitize=False).classes("gauge").props("aria-hidden=true")
    ui.label(error.said()).classes("gauge-number").props("data-testid=preview-error")
    if error.floor is not None:
        ui.label("The bar begins at 0; its line is 1, the floor: the noise.").classes("note")
