"""What the story answers: how wrong the law is, its numbers, what an effect mended, and others.

Beside the effect that is looked at stand its look-alikes and those that lower the error most.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from html import escape

from nicegui import ui

from analysis.model.verdict.standing import AT_THE_FLOOR, SURE
from rigctl.documents import Json
from rigctl.page.model.compare import is_unexpected
from rigctl.page.model.story.bars import Bar, bars
from rigctl.page.model.story.cards import card_of, in_plain
from rigctl.page.model.story.errors import Unseen, falls_to, three_figures
from rigctl.page.model.story.lead import drawing, sentence_of, shown_in
from rigctl.page.model.story.plots import before_after
from rigctl.page.model.story.preview import Shown
from rigctl.page.model.story.words import channel, goes_with, looked_at, quantity, sized
from rigctl.page.model.where import BY_POINT, apart
from rigctl.page.parts.quantities import EXPECTED
from rigctl.page.parts.tables import minus, with_error
from rigctl.page.parts.widgets import button, plot

SHOWN = 4


def others(
    known: Mapping[str, Json],
    found: Json,
    seen: Sequence[Json],
    effect: str,
    look: Callable[[str], None],
) -> None:
    """Place cards of an effect's look-alikes in one bracket, and of a few others.

    Parameters
    ----------
    known
        Documents of all effects, by name.
    seen
        Candidates of the answer `found` that these shots show, the best first.
    look
        Has another effect looked at, by its name.
    """
    like: list[str] = next((c["like"] for c in seen if c["effect"] == effect), [])
    alike = [c for c in seen if c["effect"] in like]
    rest = [c for c in seen if c not in alike and c["effect"] != effect][:SHOWN]
    if alike:
        with ui.element("div").classes("bracket").props("data-testid=look-alikes"):
            ui.label("Look-alikes: they do the same to these shots.").classes("strong")
            ui.label(
                "They bend the points in almost the same way. What tells each apart stands below "
                "it."
            ).classes("note")
            _cards(known, alike, found, look)
    ui.label("Also looked at").classes("strong")
    ui.label(looked_at(found, len(seen), len(known))).classes("note")
    _cards(known, rest, found, look)


def _cards(
    known: Mapping[str, Json],
    candidates: Sequence[Json],
    found: Json,
    look: Callable[[str], None],
) -> None:
    with ui.element("div").classes("cards"):
        for candidate in candidates:
            card = card_of(known[candidate["effect"]])
            with ui.element("div").classes("card"):
                drawing(card)
                ui.label(card.title).classes("strong")
                ui.label(card.notice).classes("note")
                _promise(found, candidate)
                placed = button(
                    "Look at it",
                    lambda name=card.effect: look(name),
                    testid=f"try-{card.effect}",
                )
                placed.props(f'aria-label="Look at {card.title}"')


def _promise(found: Json, candidate: Json) -> None:
    """Say how far the error would fall; nothing where its floor is not known."""
    error, falls = Unseen.of(found), falls_to(found, candidate)
    if error.floor is None:
        return
    if error.value <= AT_THE_FLOOR or falls.number() == error.number():
        ui.label("the error would hardly change").classes("note")
        return
    share = 1.0 - (falls.value - 1.0) / max(error.value - 1.0, 1e-9)
    with ui.element("div").classes("track").props("aria-hidden=true"):
        bar = ui.element("div").classes("bar")
        bar.style(f"width: {100 * max(0.0, min(1.0, share)):.0f}%")
    ui.label(f"error would fall to about {falls.said()}").classes("note")


LITTLE = 0.995
"""Of the error: where an effect leaves more than this share, its fall is no larger than chance."""


def fell(title: str, before: Unseen, after: Unseen) -> str:
    """Return what adding an effect did to the error."""
    lead = f"With “{title}” the error on shots that the model has not seen"
    unit = f" {after.unit}" if after.floor is None else " times the noise"
    if before.number() == after.number():
        told = f"{lead} stays at {after.number()}{unit}"
    else:
        way = "rises" if after.value > before.value else "falls"
        first = before.said() if after.floor is None else before.number()
        told = f"{lead} {way} from {first} to {after.number()}{unit}"
    if after.floor is None:
        return f"{told}."
    if after.value > LITTLE * before.value:
        told += ": too little to tell by this error alone"
    if after.value <= AT_THE_FLOOR:
        return f"{told}. Nothing can do better: 1 is the floor, and what lies below it is chance."
    return f"{told}. The floor is 1."


def changed(shown: Shown) -> None:
    """Place the points of a cell without and with an effect beside each other, on the same axes."""
    cell, first, second = shown
    first = apart(first)
    second = of_the_same(second, first)
    row = channel(cell)
    with ui.element("div").classes("columns half"):
        with ui.element("div"):
            ui.label(f"Before: the {row}").classes("strong fails")
            plot(before_after(cell, first, None))
        with ui.element("div"):
            ui.label("After, on the same axes; grey: before").classes("strong chosen")
            plot(before_after(cell, first, second)).props("data-testid=after")


def came_back(shots: Sequence[int], *, same: bool) -> str:
    """Say which shots were left out before an effect was added and fit with it.

    `same` is whether what is drawn before and after is of the same shots.
    """
    one = len(shots) == 1
    named = f"Shot {shots[0]}" if one else f"Shots {', '.join(map(str, shots))}"
    was = "was left out before: it" if one else "were left out before: they"
    fits, these = ("fits", "this one") if one else ("fit", "these")
    drawn = (
        f"Before and after are drawn of the same shots, {these} among them."
        if same
        else f"“After” alone has {these}: the model without the effect was not fitted to all shots."
    )
    return (
        f"{named} {was} lay too far from the model without the effect, and {fits} with it. {drawn}"
    )


def counts_here(shots: Sequence[int], without: Unseen, with_them: Unseen) -> str:
    """Say why the error of an effect that is looked at begins elsewhere than the verdict's."""
    one = len(shots) == 1
    named = f"Shot {shots[0]}" if one else f"Shots {', '.join(map(str, shots))}"
    fits = "fits" if one else "fit"
    return (
        f"{named}, left out so far, {fits} with this effect and {'counts' if one else 'count'} "
        f"here and in step 4: so the error begins at {with_them.said()}, not at {without.said()}."
    )


def size_of(effect: Json, after: Json) -> Json:
    """Return the size of an effect in a fit with it; its value is None where there is none."""
    name = f"{effect['effect']}.{effect['parameters'][0]['symbol']}"
    found: Json = after["parameters"].get(name) or {"value": None}
    return found


def learnt(effect: Json, before: Json, after: Json, shown: Shown | None) -> tuple[str, str]:
    """Return what an effect does, and what speaks for it: the two things to tell somebody else.

    Parameters
    ----------
    before, after
        Answers without it and with it, of the same shots.
    shown
        The cell that shows it most plainly.
    """
    card, parameter = card_of(effect), effect["parameters"][0]
    value, size = size_of(effect, after), ""
    if value["value"] is not None:
        factor, unit = shown_in(parameter, value["value"])
        bounce = after["parameters"].get("e", {}).get("value") or 0.0
        told = {name: factor * (value.get(name) or 0.0) for name in ("value", "sigma")}
        does = sentence_of(card.effect, value["value"], bounce) or parameter["meaning"]
        does = f"{does[0].lower()}{does[1:].removesuffix('.')}"
        size = f" Here: {does} ({parameter['symbol']} = {with_error(told)}{unit})."
    evidence = fell(card.title, Unseen.of(before), Unseen.of(after)).partition(". ")[0]
    evidence = f"{evidence.removesuffix('.')}{_gone(after, shown)}"
    if is_sure(value) and after["prediction_error"] > LITTLE * before["prediction_error"]:
        evidence += f"; its size is {_errors_away(value):.0f} standard errors from none"
    return f"{card.what}{size}", f"{evidence}."


def place_learnt(title: str, mechanism: str, evidence: str, as_well: str) -> None:
    """Place what somebody who found an effect can tell of it; `as_well` is what would do too."""
    with ui.element("div").classes("verdict good").props("data-testid=learnt"):
        ui.html(f"What you can say of “{escape(title)}”", sanitize=False, tag="h4")
        ui.html(f"<b>Mechanism:</b> {escape(mechanism)}", sanitize=False)
        ui.html(f"<b>Evidence:</b> {escape(evidence)}", sanitize=False)
        if as_well:
            told = f"These shots would say as much for {in_plain(as_well)}: fire those that tell."
            ui.html(f"<b>But:</b> {escape(told)}", sanitize=False).props("data-testid=as-well")


SURELY = 4.0
"""Standard errors of a size, from which on it is none by chance: 41 effects are tried."""


def is_sure(value: Json) -> bool:
    """Say whether an effect's size is surely not none."""
    return _errors_away(value) >= SURELY


def _errors_away(value: Json) -> float:
    sigma = value.get("sigma")
    return abs(value["value"]) / sigma if sigma and value["value"] is not None else 0.0


def _gone(after: Json, shown: Shown | None) -> str:
    """Say what went with something without the effect; nothing where no cell shows it by itself."""
    if shown is None or shown[0]["p_familywise"] >= SURE:
        return ""
    cell = shown[0]
    names = cell["channel"], cell["covariate"]
    left = next(
        (one for one in after["findings"] if (one["channel"], one["covariate"]) == names), None
    )
    if left is None or abs(left["deviation"]) >= abs(cell["deviation"]):
        return ""
    by_chance = left["p_familywise"] >= SURE
    rest = "no more than by chance" if by_chance else f"by {abs(left['deviation']):.0f}"
    return (
        f"; without it the {channel(cell)} errs {goes_with(cell)} by "
        f"{abs(cell['deviation']):.0f} standard deviations, with it {rest}"
    )


def of_the_same(points: Json, others: Json) -> Json:
    """Return those points of a cell whose shots and frames others have too.

    Of points that were drawn apart, each fit would leave others, and not as many.
    """
    wanted = set(zip(others["shots"], others["frames"], strict=True))
    pairs = enumerate(zip(points["shots"], points["frames"], strict=True))
    kept = [index for index, pair in pairs if pair in wanted]
    return {**points, **{name: [points[name][index] for index in kept] for name in BY_POINT}}


NAMES = {
    "e": ("bounce e", "speed of parting over speed of approach"),
    "mu": ("friction μ", "push along the surfaces over push along the line of centres"),
    "beta0": ("spin-back β₀", "share of the sliding that is turned round where the surfaces stick"),
}


def law(found: Json, before: Json | None = None) -> None:
    """Place the numbers of the law with their errors, with a mark at one beyond its range.

    `before` is the answer without the effect that was added last: what a number was stands below.
    """
    with ui.element("div").classes("law").props("data-testid=law"):
        for name, (title, meaning) in NAMES.items():
            value = found["parameters"].get(name)
            if value is None and name == "beta0" and found["with"]:
                _replaced(title, meaning, _was(before, name))
                continue
            if value is None or value["value"] is None:
                continue
            unexpected = is_unexpected(value, EXPECTED[name])
            said, was = with_error(value), _was(before, name)
            with ui.element("div").classes("unbelieved" if unexpected else "").tooltip(meaning):
                ui.label(title).classes("note")
                ui.label(f"▲ {said}" if unexpected else said).classes("law-value")
                if was not in {"", said}:
                    ui.label(f"was {was}").classes("note")
                if unexpected:
                    low, high = EXPECTED[name]
                    ui.label(
                        minus(f"believed from {low:g} to {high:g}: something missing may hide here")
                    ).classes("note fails")


def _replaced(title: str, meaning: str, was: str) -> None:
    """Say in the place of a number of the law that the law which was added has none of it."""
    with ui.element("div").tooltip(meaning):
        ui.label(title).classes("note")
        ui.label("none").classes("law-value")
        ui.label(
            f"{f'was {was}; ' if was else ''}the law that was added turns the sliding round by "
            "what the surfaces do while they touch, not by a fixed share"
        ).classes("note")


def _was(before: Json | None, name: str) -> str:
    """Return a number of the law in an earlier answer; empty where there is none."""
    value = None if before is None else before["parameters"].get(name)
    return "" if value is None or value["value"] is None else with_error(value)


LEAST_SPAN = 1.5
"""Errors in units of the noise up to which the scale of the bars goes at least."""


def worst_of(found: Json, worst: Json) -> str:
    """Return how wrong the worst quantity is, in some words."""
    if found.get("estimated"):
        return f"off by {sized(worst)}"
    if worst["p_familywise"] >= SURE:
        return "within the noise"
    times = three_figures(worst["error"])
    return f"off by {sized(worst)}, {times} × the noise"


def error_bars(rows: Sequence[Json], *, estimated: bool) -> None:
    """Place a bar for each quantity; `estimated`: its errors were not stated."""
    if estimated:
        # As multiples of a scatter that is taken for the noise all errors would be about 1.
        for row in rows:
            ui.label(f"{quantity(row)}: {sized(row)}").classes("strong")
        return
    # From the floor on, in steps of equal ratio: nothing is drawn for what is only noise.
    most = math.log(max(LEAST_SPAN, *(row["error"] for row in rows)))
    bars(
        [
            Bar(
                quantity(row),
                math.log(max(1.0, row["error"])) / most,
                f"{three_figures(row['error'])} ×",
                fails=row["p_familywise"] < SURE,
                beside=sized(row),
            )
            for row in rows
        ]
    )


def counted(rows: Sequence[Json]) -> None:
    """Say how many quantities disagree, and how the bars are read."""
    wrong = sum(row["p_familywise"] < SURE for row in rows)
    ui.label(
        f"{wrong} of {len(rows)} quantities disagree. Each bar is the error of one quantity by "
        "itself on shots that the model has not seen, as a multiple of its noise; the verdict's is "
        "that of all together. Bars begin at 1, the floor, on a logarithmic scale: a bar twice as "
        "long means the square of the error. Green may be chance alone."
    ).classes("note")
