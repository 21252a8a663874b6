"""Step 3: what is missing, by how far each effect would lower χ², and one click to add it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from string import ascii_uppercase

from nicegui import ui

from rigctl.documents import Json
from rigctl.page.model.effect_words import described, explain, in_unit, left_out
from rigctl.page.parts.quantities import CHANCE, FALL, LIKE, PLAUSIBLE, SCORE
from rigctl.page.parts.tables import chance, minus, with_error
from rigctl.page.parts.widgets import button, save_csv

SHOWN = 8
STRONG = 0.05
HEADINGS = (
    ("effect", ""),
    ("score", SCORE),
    ("alike", LIKE),
    ("amplitude, expected range", PLAUSIBLE),
    ("χ² falls by", FALL),
    ("", ""),
)


@dataclass(frozen=True, slots=True)
class _Ranked:
    """What every line of the ranking is drawn with."""

    described: dict[str, Json]
    letters: dict[str, str]
    best: float
    add: Callable[[str], None]


def missing(found: Json, add: Callable[[str], None]) -> None:
    """Place the ranking; `add` puts an effect into the model."""
    seen = [c for c in found["candidates"] if c["seen"] and c["effect"] not in found["with"]]
    best = max((abs(c["score"]) for c in seen), default=1.0) or 1.0
    ranked = _Ranked(described(found), groups(seen), best, add)
    with ui.element("div").classes("panel").props("data-testid=missing"):
        with ui.element("div").classes("title"):
            ui.label("3").classes("step")
            ui.label("What is missing")
            ui.label(_looked_at(seen, ranked.described)).classes("aside")
            ui.space()
            save_csv(f"{found['campaign']}-ranking", lambda: _rows(seen))
        with ui.element("div").classes("effects"):
            for heading, help_text in HEADINGS:
                cell = ui.label(heading).classes("cell head-cell")
                if heading not in {"effect", "score"}:
                    cell.classes("number")
                if help_text:
                    cell.tooltip(help_text)
            _lines(seen[:SHOWN], ranked)
        if rest := seen[SHOWN:]:
            _more(rest, ranked)
        left_out(found)


def _looked_at(seen: Sequence[Json], known: dict[str, Json]) -> str:
    own = sum("file" in known[c["effect"]] for c in seen)
    return f"{len(seen)} effects looked at" + (f", {own} of them your own" if own else "")


def _more(rest: Sequence[Json], ranked: _Ranked) -> None:
    """Place the button that shows the rest; what nobody looks at is not drawn."""
    place = ui.element("div").classes("wide")

    def show() -> None:
        place.clear()
        with place, ui.element("div").classes("effects"):
            _lines(rest, ranked)

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


def _lines(candidates: Sequence[Json], ranked: _Ranked) -> None:
    for candidate in candidates:
        _line(candidate, ranked)
        with ui.element("div").classes("cell"):
            strong = candidate["p_familywise"] < STRONG
            button(
                "Add",
                lambda name=candidate["effect"]: ranked.add(name),
                look="fill" if strong else "line",
                testid=f"add-{candidate['effect']}",
            )


def _line(candidate: Json, ranked: _Ranked) -> None:
    effect = ranked.described[candidate["effect"]]
    strong = candidate["p_familywise"] < STRONG
    with ui.element("div").classes("cell"):
        name = ui.element("button").classes("name").on("click", lambda: explain(effect))
        with name:
            ui.label(effect["effect"])
        title = effect["title"]
        ui.label(f"{title}, your own" if "file" in effect else title).classes("dim")
    with ui.element("div").classes("cell"):
        with ui.element("div").classes("wide"):
            share = max(1.0, 100 * abs(candidate["score"]) / ranked.best)
            bar = ui.element("div").classes("bar" if strong else "bar weak")
            bar.style(f"width: {share:.0f}%")
        said = ui.label(f"{abs(candidate['score']):.1f} σ").classes("dim")
        said.tooltip(f"p {chance(candidate['p_familywise'])}. {CHANCE}")
    ui.label(ranked.letters.get(effect["effect"], "")).classes("cell number")
    _amplitude(candidate, effect["parameters"])
    ui.label(f"{candidate['promised_fall']:.0f}").classes("cell number")


def _amplitude(candidate: Json, parameters: Sequence[Json]) -> None:
    """Place what a candidate's size is estimated to be, beside the range that is expected of it."""
    symbol, value = next(iter(candidate["amplitudes"].items()))
    parameter = next((one for one in parameters if one["symbol"] == symbol), None)
    if parameter is None:
        # Of an effect that is ranked as a share of itself at its usual size.
        with ui.element("div").classes("cell number"):
            ui.label(with_error(value))
            ui.label("of its usual size").classes("dim")
        return
    low, high = parameter["plausible"]
    unit = in_unit(parameter)
    with ui.element("div").classes("cell number"):
        text = ui.label(f"{symbol} = {with_error(value)}{unit}")
        text.tooltip(f"{parameter['meaning']}; expected from {low:g} to {high:g}{unit}")
        if not candidate["plausible"]:
            text.classes("warn")
        with ui.element("div").classes("range"):
            place = (value["value"] - low) / (high - low) if high > low else 0.5
            dot = ui.element("div").classes("dot" if 0 <= place <= 1 else "dot out")
            dot.style(f"left: {100 * min(max(place, 0.0), 1.0):.0f}%")
        ui.label(minus(f"{low:g} … {high:g}{unit}")).classes("dim")


def _rows(candidates: Sequence[Json]) -> list[list[object]]:
    names = ["effect", "score", "promised_fall", "p_familywise", "amplitude", "unit", "plausible"]
    return [names, *([c[name] for name in names] for c in candidates)]
