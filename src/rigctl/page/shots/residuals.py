"""One shot against the model that its campaign was fitted with."""

from __future__ import annotations

from dataclasses import dataclass

from nicegui import ui

from analysis.figures.palette import FAILS, MEASURED
from rigctl.documents import Json
from rigctl.page.desk import Desk
from rigctl.page.layout import TICK_S
from rigctl.page.model.compare import parsed
from rigctl.page.model.source import Source
from rigctl.page.model.state import Question
from rigctl.page.parts.following import following
from rigctl.page.parts.plots import figure
from rigctl.page.parts.widgets import button, plot, save_csv
from rigctl.store import ShotRecord, ShotState

FAR = 3.0
HELP = (
    "What the poses want beyond the model, as a jump at contact, in units of its own standard "
    "error. n: along the normal; t: along the incident surface velocity; b: across both. relative: "
    "b less a; common: mean of a and b."
)


@dataclass(frozen=True, slots=True)
class Residual:
    """What one quantity's jump at contact is beyond the model, with its standard error."""

    quantity: str
    value: float
    sigma: float
    unit: str

    @property
    def deviations(self) -> float:
        """The residual in units of its standard error."""
        return self.value / self.sigma


def is_jump(channel: str) -> bool:
    """Say whether a channel is a jump at contact, of a velocity or a spin."""
    return "velocity" in channel or "spin" in channel


def residuals_of(number: int, cells: list[Json]) -> list[Residual]:
    """Return the jumps at contact of the shot of this number; empty where it was not used."""
    found: dict[str, Residual] = {}
    for cell in cells:
        # What runs from frame to frame is no jump of one shot.
        if cell["channel"] in found or not is_jump(cell["channel"]):
            continue
        points = parsed(cell["points"])
        if number in points["shots"]:
            place = points["shots"].index(number)
            value, sigma = points["residual"][place], points["sigma"][place]
            found[cell["channel"]] = Residual(cell["channel"], value, sigma, points["unit"])
    return sorted(found.values(), key=lambda one: (one.quantity.split()[1], one.quantity))


class ShotResiduals:
    """Panel that fits the shot's campaign when it is asked to, and shows what the shot leaves.

    Parameters
    ----------
    effects
        Added to the base model; None: nobody has asked yet, the operator does.
    """

    def __init__(self, desk: Desk, shot: ShotRecord, effects: tuple[str, ...] | None) -> None:
        self._desk, self._shot = desk, shot
        self._effects = effects or ()
        source = Source(desk.daemon, shot.campaign or "")
        self._asked = Question(lambda: source.ask("picture", self._effects), desk.daemon.jobs.job)
        with ui.element("div").classes("panel").props("data-testid=shot-residuals"):
            self._show()
        if effects is not None and shot.campaign and shot.state is ShotState.ANALYSED:
            self._start()
        following(TICK_S * 2, self._follow)

    def _start(self) -> None:
        self._asked.start()
        self._show.refresh()

    def _follow(self) -> None:
        if self._asked.follow():
            self._show.refresh()

    @ui.refreshable_method
    def _show(self) -> None:
        shot, answer = self._shot, self._asked.answer
        with ui.element("div").classes("title"):
            ui.label("Against the model").tooltip(HELP)
            if self._effects:
                ui.label(f"with {', '.join(self._effects)}").classes("aside")
            ui.space()
            if answer is not None:
                found = residuals_of(shot.number, answer["findings"])
                rows: list[list[object]] = [["quantity", "residual", "sigma", "unit"]]
                rows += [[one.quantity, one.value, one.sigma, one.unit] for one in found]
                save_csv(f"shot-{shot.number}-residuals", lambda: rows)
        if shot.campaign is None:
            ui.label("It belongs to no campaign, so no model is fitted to it.").classes("empty")
        elif shot.state is not ShotState.ANALYSED:
            ui.label("Only a measured shot is compared.").classes("empty")
        elif answer is not None:
            _compared(shot, answer)
        else:
            self._offer(shot.campaign)

    def _offer(self, campaign: str) -> None:
        if self._asked.failure:
            ui.label(self._asked.failure).classes("verdict bad")
        if self._asked.running is not None:
            with ui.element("div").classes("busy"):
                ui.spinner(size="sm")
                ui.label(f"fitting {campaign} …")
            return
        ui.label(f"Fits the campaign “{campaign}” and shows what this shot leaves over.").classes(
            "note"
        )
        button("Compare", self._start, testid="compare-shot")


def rejected_of(found: Json) -> dict[int, str]:
    """Return why a fit left out each shot that it did, by its number."""
    return dict(zip(found["rejected"], found["rejected_why"], strict=True))


def _compared(shot: ShotRecord, answer: Json) -> None:
    if (why := rejected_of(answer).get(shot.number)) is not None:
        ui.label(f"The fit left this shot out: {why}.").classes("verdict bad")
        return
    if shot.number in answer["excluded"]:
        ui.label("The fit left this shot out: a person excluded it.").classes("empty")
        return
    found = residuals_of(shot.number, answer["findings"])
    if not found:
        ui.label("The fit did not use this shot.").classes("empty")
        return
    worst = max(found, key=lambda one: abs(one.deviations))
    far = abs(worst.deviations) > FAR
    ui.label(
        f"Farthest: {worst.quantity}, {worst.value:+.3g} ± {worst.sigma:.2g} {worst.unit}."
        + ("" if far else " Nothing beyond three standard errors.")
    ).classes("note")
    plot(pulls(found, f"shot-{shot.number}-residuals"))


def pulls(found: list[Residual], name: str) -> Json:
    """Return residuals in units of their errors, one line a quantity; far ones are triangles."""
    deviations = [one.deviations for one in found]
    reach = 1.1 * max(FAR, *(abs(one) for one in deviations))
    far = [abs(one) > FAR for one in deviations]
    band = {
        "type": "rect",
        "yref": "paper",
        "x0": -2,
        "x1": 2,
        "y0": 0,
        "y1": 1,
        "fillcolor": "rgba(0,158,115,0.12)",
        "line": {"width": 0},
        "layer": "below",
    }
    points = {
        "type": "scatter",
        "mode": "markers",
        "x": deviations,
        "y": [one.quantity for one in found],
        "marker": {
            "size": 9,
            "color": [FAILS if one else MEASURED for one in far],
            "symbol": ["triangle-up" if one else "circle" for one in far],
        },
        "customdata": [f"{one.value:.3g} ± {one.sigma:.2g} {one.unit}" for one in found],
        "hovertemplate": "%{y}: %{customdata}<extra></extra>",
    }
    return figure(
        [points],
        70 + 22 * len(found),
        name,
        shapes=[band],
        margin={"l": 132, "r": 12, "t": 8, "b": 44},
        xaxis={"title": {"text": "residual / its standard error"}, "range": [-reach, reach]},
        yaxis={"autorange": "reversed", "fixedrange": True},
    )
