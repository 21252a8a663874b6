"""The form of a sweep: a grid of pressure and offset, or shots that somebody proposes."""

from __future__ import annotations

import hashlib
import math
import secrets
from urllib.parse import quote

from nicegui import run, ui
from pydantic import ValidationError

from analysis.errors import counted
from rigctl.config import Limits
from rigctl.errors import RigError
from rigctl.page.desk import Desk, actor
from rigctl.page.parts.fields import CampaignField, NumberField
from rigctl.page.parts.presence import every
from rigctl.page.parts.quantities import SETTINGS, Quantity
from rigctl.page.parts.readings import turns_until
from rigctl.page.parts.tables import Cell, Line, facts
from rigctl.page.parts.widgets import button, plot
from rigctl.page.sweeps.plots import RESTS_ON, covers, grid
from rigctl.sweeps.form import Grid, Sweep
from rigctl.sweeps.plan import plan_of, require_possible, warnings_of

MOST_LEVELS = 50
MOST_REPEATS = 100
ALIKE = ("pressure_a_kpa", "offset_mm")
"""Settings that a grid goes through whose pressures are alike on both sides."""
LISTED = {"pressure_a_kpa": "a", "pressure_b_kpa": "b", "offset_mm": "offset"}
LOOKED_AT = 60
"""So many shots measured last say what friction does."""
REPEAT = Quantity("Repeats", "", "How often all is fired.")


def form_address(proposed: Sweep) -> str:
    """Return where the page offers these shots: nothing is fired before somebody starts them."""
    return f"/sweeps?form={quote(proposed.model_dump_json(exclude_defaults=True))}"


def shot_headings() -> list[Cell]:
    """Return the headings of a table of listed shots."""
    headings = [
        Cell(f"{short}, {SETTINGS[name].unit}", f"{SETTINGS[name].name}. {SETTINGS[name].meaning}")
        for name, short in LISTED.items()
    ]
    return [*headings, Cell("times", "How often it is fired.")]


class SweepForm:
    """Fields, the preview of the shots they mean, and the start.

    Parameters
    ----------
    proposed
        JSON text of a sweep whose listed shots stand in the place of a grid; empty: none.
    """

    def __init__(self, desk: Desk, proposed: str = "") -> None:
        self._desk = desk
        self._key = secrets.token_hex(16)
        limits = desk.daemon.configuration.limits
        with ui.element("div").classes("panel"):
            ui.label("New sweep").classes("title")
            self._proposed = _proposed(proposed)
            if self._proposed is None:
                self._fields = _fields(limits)
            else:
                _listed(self._proposed)
                self._fields = {"repeat": _repeat(float(self._proposed.repeat))}
            known = None if self._proposed is None else self._proposed.campaign
            self._campaign = CampaignField(known or "sweep")
            self._shuffle = ui.checkbox("in random order", value=True).props("dense")
            self._shuffle.tooltip("so that a drift in time is no effect of a setting")
            self._said = ui.label().classes("note").props("data-testid=sweep-text role=status")
            self._start = button("Start", self._on_start, look="main fill", testid="start-sweep")
        self._shown: Sweep | None = None
        self._turned_until: float | None = None
        ui.timer(0.0, self._read, once=True)
        every(0.3, self._follow)

    @property
    def is_proposed(self) -> bool:
        """Whether the shots are proposed, so that there is nothing to choose."""
        return self._proposed is not None

    @ui.refreshable_method
    def preview(self) -> None:
        """Place the shots of the sweep in the plane of pressure and offset."""
        with ui.element("div").classes("panel").props("data-testid=preview"):
            with ui.element("div").classes("title"):
                ui.label("What it covers")
                if self._shown is not None:
                    said = covers(self._shown.steps(), self._turned_until)
                    ui.label(said).classes("aside").props("data-testid=covers")
            if self._shown is None:
                ui.label("The fields do not make a sweep yet.").classes("empty")
                return
            plot(grid(self._shown.steps(), self._desk.daemon.configuration.limits))
            ui.label(RESTS_ON).classes("note")

    async def _read(self) -> None:
        """Learn from the shots of this rig what friction makes of the sliding."""

        def read() -> float | None:
            shots = self._desk.daemon.store.catalogue.latest(LOOKED_AT, None)
            own = [shot for shot in shots if shot.imported_as is None]
            return turns_until(self._desk.readings.of(own))

        self._turned_until = await run.io_bound(read)
        self.preview.refresh()

    def _follow(self) -> None:
        try:
            sweep = self._sweep()
            plan, configuration = plan_of(sweep), self._desk.daemon.configuration
            require_possible(plan, configuration.limits)
            said = ". ".join([counted(sweep.count(), "shot"), *warnings_of(plan, configuration)])
        except ValidationError as error:
            sweep, said = None, str(error.errors()[0]["msg"])
        except RigError as error:
            sweep, said = None, error.sentence()
        self._said.set_text(said)
        self._start.set_enabled(sweep is not None and self._campaign.valid)
        if sweep != self._shown:
            self._shown = sweep
            self.preview.refresh()

    def _sweep(self) -> Sweep:
        value = {name: field.value for name, field in self._fields.items()}
        common = {
            "repeat": _whole(value["repeat"]),
            "shuffle": bool(self._shuffle.value),
            "campaign": self._campaign.value or None,
        }
        if self._proposed is not None:
            return Sweep.model_validate({**self._proposed.model_dump(), **common})
        levels = {
            "pressure_a_kpa": _levels(value["p0"], value["p1"], value["pn"], "root"),
            "offset_mm": _levels(value["o0"], value["o1"], value["on"], "linear"),
        }
        return Sweep.model_validate({**common, "grid": levels, "note": "built on the page"})

    async def _on_start(self) -> None:
        sweep, who, key = self._sweep(), actor(), self._key
        digest = hashlib.sha256(sweep.model_dump_json().encode()).hexdigest()
        started = await self._desk.act(
            lambda: self._desk.daemon.sweeps.start(plan_of(sweep), key, digest, who),
            moves=True,
        )
        if started is not None:
            self._key = secrets.token_hex(16)
            ui.navigate.to(f"/sweeps/{started.record.id}")


def _proposed(text: str) -> Sweep | None:
    if not text:
        return None
    try:
        return Sweep.model_validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"])) or "the form"
        ui.label(f"The proposed shots are no sweep: {place}: {first['msg']}.").classes(
            "verdict bad"
        )
        return None


def _listed(proposed: Sweep) -> None:
    """Place the shots of a proposal; they are fired as they stand."""
    ui.label(f"Proposed: {proposed.note or 'listed shots'}.").classes("note")
    lines = [
        Line([*(f"{getattr(shot, name):g}" for name in LISTED), str(shot.repeat)])
        for shot in proposed.shots
    ]
    if lines:
        facts(shot_headings(), lines, "proposed")
    if proposed.grid is not None:
        ui.label(f"{grid_words(proposed.grid)}: see “What it covers”.").classes("note")
    ui.link("Choose pressures and offsets yourself instead", "/sweeps").classes("note")


def grid_words(proposed: Grid) -> str:
    """Say which settings a grid goes through, each with how many values and their ends."""
    said: list[str] = []
    for name in LISTED if proposed.pressure_b_kpa is not None else ALIKE:
        about, values = SETTINGS[name], {getattr(one, name) for one in proposed.settings()}
        ends = f"{min(values):g}"
        if len(values) > 1:
            ends += f" to {max(values):g}"
        said.append(f"{about.name} {ends} {about.unit} ({counted(len(values), 'value')})")
    return ", ".join(said)


def _repeat(value: float) -> NumberField:
    return NumberField(REPEAT, (1, MOST_REPEATS), value, "repeat")


def _fields(limits: Limits) -> dict[str, NumberField]:
    low, high = limits.pressure_kpa
    counted = (1.0, float(MOST_LEVELS))
    bounds = {
        "p0": (Quantity("Pressure from", "kPa", "Of both pushers alike."), (low, high), 20.0),
        "p1": (Quantity("Pressure to", "kPa", "Of both pushers alike."), (low, high), 80.0),
        "pn": (Quantity("Pressures", "", "Spaced so that speeds are even."), counted, 4.0),
        "o0": (Quantity("Offset from", "mm", "0 is head on."), limits.offset_mm, 0.0),
        "o1": (Quantity("Offset to", "mm", "Near 25.4 mm they graze."), limits.offset_mm, 22.0),
        "on": (Quantity("Offsets", "", "Spaced evenly."), counted, 6.0),
    }
    placed = {
        name: NumberField(about, own, min(max(start, own[0]), own[1]), name)
        for name, (about, own, start) in bounds.items()
    }
    return {**placed, "repeat": _repeat(1.0)}


def _levels(first: float, last: float, count: float, spacing: str) -> object:
    if count == 1 or first == last:
        return [first]
    return {"first": first, "last": last, "count": _whole(count), "spacing": spacing}


def _whole(value: float) -> int:
    """Return a count; an empty field, which is not a number, counts nothing."""
    return 0 if math.isnan(value) else int(value)
