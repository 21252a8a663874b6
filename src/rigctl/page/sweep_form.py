"""The form of a sweep: ranges of pressure and offset, and what they cover before anything moves."""

from __future__ import annotations

import hashlib
import math
import secrets
from typing import Any

from nicegui import ui
from pydantic import ValidationError

from analysis.figures.palette import MEASURED
from rigctl.config import Limits
from rigctl.errors import RigError
from rigctl.page.desk import Desk, actor
from rigctl.page.fields import CampaignField, NumberField
from rigctl.page.plots import figure
from rigctl.page.quantities import Quantity
from rigctl.page.widgets import button, plot
from rigctl.settings import ShotSettings
from rigctl.sweeps.form import Sweep
from rigctl.sweeps.plan import plan_of, require_possible

Json = dict[str, Any]
DIAMETER_MM = 25.4
MOST_LEVELS = 50
MOST_REPEATS = 100


class SweepForm:
    """Fields, the preview of the shots they mean, and the start."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        limits = desk.daemon.configuration.limits
        self._key = secrets.token_hex(16)
        with ui.element("div").classes("panel"):
            ui.label("New sweep").classes("title")
            self._fields = _fields(limits)
            self._campaign = CampaignField("sweep")
            self._shuffle = ui.checkbox("in a drawn order", value=True).props("dense")
            self._shuffle.tooltip("so that a drift in time is no effect of a setting")
            self._said = ui.label().classes("note").props("data-testid=sweep-says")
            self._start = button("Start", self._on_start, look="main fill", testid="start-sweep")
        self._shown: Sweep | None = None
        ui.timer(0.3, self._follow)

    @ui.refreshable_method
    def preview(self) -> None:
        """Place the shots of the sweep in the plane of pressure and offset."""
        with ui.element("div").classes("panel"):
            with ui.element("div").classes("title"):
                ui.label("What it covers")
                if self._shown is not None:
                    ui.label(_covers(self._shown.steps())).classes("aside")
            if self._shown is None:
                ui.label("The fields do not make a sweep yet.").classes("empty")
                return
            plot(_grid(self._shown.steps(), self._desk.daemon.configuration.limits))

    def _follow(self) -> None:
        try:
            sweep = self._sweep()
            require_possible(plan_of(sweep), self._desk.daemon.configuration.limits)
            said = f"{sweep.count()} shots"
        except ValidationError as error:
            sweep, said = None, str(error.errors()[0]["msg"])
        except RigError as error:
            sweep, said = None, error.sentence()
        valid = sweep is not None and self._campaign.valid
        self._said.set_text(said)
        self._start.set_enabled(valid)
        if sweep != self._shown:
            self._shown = sweep
            self.preview.refresh()

    def _sweep(self) -> Sweep:
        value = {name: field.value for name, field in self._fields.items()}
        grid = {
            "pressure_a_kpa": _levels(value["p0"], value["p1"], value["pn"], "root"),
            "offset_mm": _levels(value["o0"], value["o1"], value["on"], "linear"),
        }
        return Sweep.model_validate(
            {
                "grid": grid,
                "repeat": _whole(value["repeat"]),
                "shuffle": bool(self._shuffle.value),
                "campaign": self._campaign.value or None,
                "note": "built on the page",
            }
        )

    async def _on_start(self) -> None:
        sweep, who, key = self._sweep(), actor(), self._key
        digest = hashlib.sha256(sweep.model_dump_json().encode()).hexdigest()
        started = await self._desk.act(
            lambda: self._desk.daemon.sweeps.start(plan_of(sweep), key, digest, who)
        )
        if started is not None:
            self._key = secrets.token_hex(16)
            ui.notify(f"Sweep {started.record.id} runs.")


def _fields(limits: Limits) -> dict[str, NumberField]:
    low, high = limits.pressure_kpa
    bounds = {
        "p0": (Quantity("Pressure from", "kPa", "Of both pushers alike."), (low, high), 20.0),
        "p1": (Quantity("Pressure to", "kPa", "Of both pushers alike."), (low, high), 80.0),
        "pn": (
            Quantity("Pressures", "", "Spaced so that speeds are."),
            (1.0, float(MOST_LEVELS)),
            4.0,
        ),
        "o0": (Quantity("Offset from", "mm", "0 is head on."), limits.offset_mm, 0.0),
        "o1": (Quantity("Offset to", "mm", "Near 25.4 mm they graze."), limits.offset_mm, 22.0),
        "on": (Quantity("Offsets", "", "Spaced evenly."), (1.0, float(MOST_LEVELS)), 6.0),
        "repeat": (Quantity("Repeats", "", "How often all is fired."), (1, MOST_REPEATS), 1.0),
    }
    return {
        name: NumberField(about, own, min(max(start, own[0]), own[1]), name)
        for name, (about, own, start) in bounds.items()
    }


def _levels(first: float, last: float, count: float, spacing: str) -> object:
    if count == 1 or first == last:
        return [first]
    return {"first": first, "last": last, "count": _whole(count), "spacing": spacing}


def _whole(value: float) -> int:
    """Return a count; an empty field, which is not a number, counts nothing."""
    return 0 if math.isnan(value) else int(value)


def _covers(steps: list[ShotSettings]) -> str:
    """Say which incidence the offsets mean: without fall, its sine is offset over diameter."""
    reach = [min(abs(step.offset_mm) / DIAMETER_MM, 0.999) for step in steps]
    low, high = (share / (1 - share**2) ** 0.5 for share in (min(reach), max(reach)))
    return f"{len(steps)} shots, v_s/v_n from about {low:.2f} to {high:.2f} before they fall"


def _grid(steps: list[ShotSettings], limits: Limits) -> Json:
    shots: dict[tuple[float, float], int] = {}
    for step in steps:
        place = step.pressure_a_kpa, step.offset_mm
        shots[place] = shots.get(place, 0) + 1
    points = {
        "type": "scatter",
        "mode": "markers",
        "x": [pressure for pressure, _ in shots],
        "y": [offset for _, offset in shots],
        "customdata": list(shots.values()),
        "marker": {"color": MEASURED, "size": 10},
        "hovertemplate": "%{x:.1f} kPa, %{y:.2f} mm, %{customdata} times<extra></extra>",
    }
    room = 0.04 * (limits.pressure_kpa[1] - limits.pressure_kpa[0])
    rise = 0.06 * (limits.offset_mm[1] - limits.offset_mm[0])
    return figure(
        [points],
        330,
        "sweep",
        xaxis={
            "title": {"text": "pressure, kPa"},
            "range": [limits.pressure_kpa[0] - room, limits.pressure_kpa[1] + room],
            "zeroline": False,
        },
        yaxis={
            "title": {"text": "offset, mm"},
            "range": [limits.offset_mm[0] - rise, limits.offset_mm[1] + rise],
            "zeroline": False,
        },
    )
