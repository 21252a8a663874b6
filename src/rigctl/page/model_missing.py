"""Step 3: what is missing, by what each effect promises, and one click to add it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from string import ascii_uppercase
from typing import Any

from nicegui import ui

from analysis.effects.effect import Effect
from rigctl.known_effects import ALL_EFFECTS
from rigctl.page.quantities import CHANCE, FALL, LIKE, PLAUSIBLE, SCORE
from rigctl.page.tables import chance, minus, with_error
from rigctl.page.widgets import button, save_csv

Json = dict[str, Any]
SHOWN = 8
STRONG = 0.05
_EFFECTS: dict[str, Effect] = {effect.name: effect for effect in ALL_EFFECTS}
HEADINGS = (
    ("effect", ""),
    ("score", SCORE),
    ("alike", LIKE),
    ("amplitude, believed range", PLAUSIBLE),
    ("χ² falls by", FALL),
    ("", ""),
)


def missing(found: Json, add: Callable[[str], None], *, waiting: bool) -> None:
    """Place the ranking; `add` puts an effect into the model, unless an answer is waited for."""
    seen = [c for c in found["candidates"] if c["seen"] and c["effect"] not in found["with"]]
    with ui.element("div").classes("panel").props("data-testid=missing"):
        with ui.element("div").classes("title"):
            ui.label("3").classes("step")
            ui.label("What is missing")
            ui.label(f"{len(seen)} effects of the catalogue looked at").classes("aside")
            ui.space()
            save_csv(f"{found['campaign']}-ranking", lambda: _rows(seen))
        with ui.element("div").classes("effects"):
            for heading, help_text in HEADINGS:
                cell = ui.label(heading).classes("cell head-cell")
                if heading not in {"effect", "score"}:
                    cell.classes("number")
                if help_text:
                    cell.tooltip(help_text)
            _lines(seen[:SHOWN], add, waiting=waiting)
            rest = seen[SHOWN:]
        if rest:
            _more(rest, add, waiting=waiting)


def _more(rest: Sequence[Json], add: Callable[[str], None], *, waiting: bool) -> None:
    """Place the button that shows the rest; what nobody looks at is not drawn."""
    place = ui.element("div").classes("wide")

    def show() -> None:
        place.clear()
        with place, ui.element("div").classes("effects"):
            _lines(rest, add, waiting=waiting)

    with place:
        button(f"{len(rest)} more", show, look="line tab")


def groups(candidates: Sequence[Json]) -> dict[str, str]:
    """Return a letter for each effect that these shots do not tell from another one.

    An effect joins the first group of which it is like every member.
    """
    like = {c["effect"]: set(c["like"]) for c in candidates}
    found: list[list[str]] = []
    for name, own in like.items():
        group = next((g for g in found if all(other in own for other in g)), None)
        if group is None:
            found.append([name])
        else:
            group.append(name)
    company = [group for group in found if len(group) > 1]
    return {
        name: letter
        for letter, group in zip(ascii_uppercase, company, strict=False)
        for name in group
    }


def _lines(candidates: Sequence[Json], add: Callable[[str], None], *, waiting: bool) -> None:
    letters = groups(candidates)
    best = max((abs(c["score"]) for c in candidates), default=1.0) or 1.0
    for candidate in candidates:
        _line(candidate, letters.get(candidate["effect"], ""), best)
        with ui.element("div").classes("cell"):
            strong = candidate["p_familywise"] < STRONG
            adding = button(
                "Add",
                lambda name=candidate["effect"]: add(name),
                look="fill" if strong else "line",
                testid=f"add-{candidate['effect']}",
            )
            adding.set_enabled(not waiting)


def _line(candidate: Json, letter: str, best: float) -> None:
    effect = _EFFECTS[candidate["effect"]]
    strong = candidate["p_familywise"] < STRONG
    with ui.element("div").classes("cell"):
        name = ui.element("button").classes("name").on("click", lambda: _explain(effect))
        with name:
            ui.label(effect.name)
        ui.label(effect.title).classes("dim")
    with ui.element("div").classes("cell"):
        with ui.element("div").classes("wide"):
            share = max(1.0, 100 * abs(candidate["score"]) / best)
            bar = ui.element("div").classes("bar" if strong else "bar weak")
            bar.style(f"width: {share:.0f}%")
        said = ui.label(f"{abs(candidate['score']):.1f} σ").classes("dim")
        said.tooltip(f"p {chance(candidate['p_familywise'])}. {CHANCE}")
    ui.label(letter).classes("cell number")
    _amplitude(candidate, effect)
    ui.label(f"{candidate['promised_fall']:.0f}").classes("cell number")


def _amplitude(candidate: Json, effect: Effect) -> None:
    symbol, value = next(iter(candidate["amplitudes"].items()))
    parameter = effect.parameters[0]
    low, high = parameter.plausible
    unit = "" if parameter.unit == "1" else f" {parameter.unit}"
    with ui.element("div").classes("cell number"):
        text = ui.label(f"{symbol} = {with_error(value)}{unit}")
        text.tooltip(f"{parameter.meaning}; believed from {low:g} to {high:g}{unit}")
        if not candidate["plausible"]:
            text.classes("warn")
        with ui.element("div").classes("range"):
            place = (value["value"] - low) / (high - low) if high > low else 0.5
            dot = ui.element("div").classes("dot" if 0 <= place <= 1 else "dot out")
            dot.style(f"left: {100 * min(max(place, 0.0), 1.0):.0f}%")
        ui.label(minus(f"{low:g} … {high:g}{unit}")).classes("dim")


def _explain(effect: Effect) -> None:
    with ui.dialog(value=True) as dialog, ui.card().classes("ask"):
        with ui.element("div").classes("title"):
            ui.label(effect.title)
            ui.label(f"{effect.name}, acts in: {effect.stage}").classes("aside")
        ui.label(effect.formula).classes("formula")
        for parameter in effect.parameters:
            unit = "" if parameter.unit == "1" else f", {parameter.unit}"
            ui.label(f"{parameter.symbol}{unit}: {parameter.meaning}")
        ui.label(f"What betrays it: {effect.gives_away}")
        if effect.confused_with:
            ui.label(f"Easily confused with: {', '.join(effect.confused_with)}")
        ui.label(f"Source: {effect.source}").classes("note")
        with ui.element("div").classes("beside ends"):
            button("Close", dialog.close)
    dialog.on("hide", dialog.delete)


def _rows(candidates: Sequence[Json]) -> list[list[object]]:
    names = ["effect", "score", "promised_fall", "p_familywise", "amplitude", "unit", "plausible"]
    return [names, *([c[name] for name in names] for c in candidates)]
