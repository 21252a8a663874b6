"""The four steps side by side: panels that stay, in which each answer is drawn."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from string import ascii_uppercase
from typing import Any

from nicegui import ui

from rigctl.documents import Json
from rigctl.page.desk import Desk
from rigctl.page.model.compare import compare
from rigctl.page.model.effect_words import described, explain, in_unit, left_out
from rigctl.page.model.state import Effects, ModelState
from rigctl.page.model.where import Where
from rigctl.page.parts.plots import error_path
from rigctl.page.parts.quantities import CHANCE, ERROR, FALL, LIKE, PLAUSIBLE, SCORE
from rigctl.page.parts.tables import chance, minus, with_error
from rigctl.page.parts.widgets import button, plot, redraw, save_csv

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


SAMPLING_ERRORS = 2.0


class GrownPath:
    """The plot of the error on shots left out; `take` goes back to earlier effects."""

    def __init__(self, state: ModelState, take: Callable[[Effects], None]) -> None:
        self._state = state
        with ui.element("div").classes("panel").props("data-testid=error-path"):
            with ui.element("div").classes("title"):
                ui.label("4").classes("step")
                ui.label("Error path")
                ui.label("error on shots left out; green: the floor").classes("aside").tooltip(
                    ERROR
                )
                ui.space()
                save_csv(f"{state.source.title}-error-path", self._rows)
                self._undo = button("Undo", lambda: take(state.effects[:-1]), testid="undo")
            self._plot = plot(self._figure())
            self._note = ui.label(
                "Add an effect in step 3: the path grows and shows what it brings."
            ).classes("note")
        self._enable()

    def show(self) -> None:
        """Draw the path to the present effects, as far as it is known."""
        figure = self._figure()
        if figure != self._plot.figure:
            redraw(self._plot, figure)
        self._enable()

    def _enable(self) -> None:
        self._undo.set_enabled(bool(self._state.effects))
        self._note.set_visibility(not self._state.effects)

    def _labels(self) -> list[str]:
        known = len(self._state.path())
        return ["base model", *(f"+ {name}" for name in self._state.effects)][:known]

    def _figure(self) -> dict[str, Any]:
        path = self._state.path()
        errors = [stage["prediction_error"] for stage in path]
        bars = [SAMPLING_ERRORS * stage["prediction_error_sampling"] for stage in path]
        return error_path(self._labels(), errors, bars)

    def _rows(self) -> list[list[object]]:
        rows: list[list[object]] = [["stage", "error", "chi2_per_dof"]]
        stages = zip(self._labels(), self._state.path(), strict=True)
        return rows + [
            [label, stage["prediction_error"], stage["chi2_per_dof"]] for label, stage in stages
        ]


class Steps:
    """Compare, where it fails, what is missing, error path; nothing before the first answer.

    `take` has the model taken with other effects. `last` is where more can be placed after them.
    """

    def __init__(self, desk: Desk, state: ModelState, take: Callable[[Effects], None]) -> None:
        self._desk, self._state, self._take = desk, state, take
        self._shown: Json = {}
        self._due = False
        # In the order in which they are read: in rows, or in one column on a tablet.
        with ui.element("div").classes("columns model nothing") as self._all:
            self._first, self._second, self._offered = (ui.element("div") for _ in range(3))
            self.last = ui.element("div").classes("stack")
            with self.last:
                self._fourth = ui.element("div")
        self.show()

    def show(self) -> None:
        """Draw the latest answer on the way to the present effects."""
        known = self._state.path()
        if not known:
            return
        shown, before = self._state.present or known[-1], self._shown
        self._shown = shown
        if not before:
            self._build()
            return
        if shown is not before:
            self._compared.refresh()
            # A plot that is drawn over costs half of one that is made anew.
            self._where.show(shown)
            self._due = True
        self._path.show()
        self._hold()

    def rank(self) -> None:
        """Draw the ranking of the answer that `show` drew, once the browser has begun with that.

        It is a third of all that is drawn, and what was asked is answered above it.
        """
        if self._due:
            self._due = False
            self._ranked.refresh()
            self._hold()

    def _build(self) -> None:
        self._all.classes(remove="nothing")
        with self._first:
            self._compared()
        with self._second:
            self._where = Where(self._desk, self._state, self._shown)
        with self._offered:
            self._ranked()
        with self._fourth:
            self._path = GrownPath(self._state, self._take)
        self._hold()

    def _hold(self) -> None:
        """Let no effect be added from a ranking that is not that of the present effects."""
        waiting = self._due or self._state.present is None
        self._offered.props(add="inert" if waiting else None, remove=None if waiting else "inert")

    @ui.refreshable_method
    def _compared(self) -> None:
        compare(self._shown)

    @ui.refreshable_method
    def _ranked(self) -> None:
        missing(self._shown, self._add)

    def _add(self, name: str) -> None:
        self._take((*self._state.effects, name))
