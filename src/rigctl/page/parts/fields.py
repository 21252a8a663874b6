"""Fields that say their unit and their range, and say so again when a value lies outside."""

from __future__ import annotations

import math
from pathlib import Path

from nicegui import ui
from pydantic import TypeAdapter, ValidationError

from rigctl.config import Limits
from rigctl.page.parts.quantities import SETTINGS, Quantity
from rigctl.page.parts.tables import minus
from rigctl.plain_text import CampaignName
from rigctl.settings import ShotSettings

_CAMPAIGN: TypeAdapter[str] = TypeAdapter(CampaignName)
_RANGES = {
    "pressure_a_kpa": "pressure_kpa",
    "pressure_b_kpa": "pressure_kpa",
    "offset_mm": "offset_mm",
    "delay_us": "delay_us",
    "angle_a_deg": "angle_deg",
    "angle_b_deg": "angle_deg",
}
SCRIPT = Path(__file__).with_name("fields.js")
STEPS = {"pressure_a_kpa": 1.0, "pressure_b_kpa": 1.0, "offset_mm": 0.5}
"""Steps of the sliders; a delay has none, as nearly all shots have none."""
PLACES = 3
"""So many places a field starts with: finer than any rig sets."""
START = {"pressure_a_kpa": 40.0, "pressure_b_kpa": 40.0, "offset_mm": 6.0, "delay_us": 0.0}
"""Values that a first shot starts from, as far as the rig allows them."""


class NumberField:
    """A number with its unit and its range; where a step is given, with a slider beside it."""

    def __init__(
        self,
        about: Quantity,
        bounds: tuple[float, float],
        value: float,
        name: str,
        *,
        step: float | None = None,
    ) -> None:
        self._bounds = bounds
        self._slider: ui.element | None = None
        low, high = bounds
        with ui.element("div").classes("field"):
            with ui.element("div").classes("caption"):
                ui.label(about.name).tooltip(about.meaning)
                ui.label(minus(f"{about.unit}, {low:g} to {high:g}".lstrip(", ")))
            with ui.element("div").classes("slid" if step else "wide"):
                if step is not None:
                    self._slider = _slider(about, bounds, value, step, name)
                self._field = ui.number(
                    value=value,
                    validation=lambda given: self._fault(given, about.unit),
                )
            self._field.props(
                f'outlined dense hide-bottom-space aria-label="{about.name}" data-testid={name}'
            )

    @property
    def value(self) -> float:
        """What the field holds; not a number where it is empty."""
        given = self._field.value
        return math.nan if given is None else float(given)

    @property
    def valid(self) -> bool:
        """Whether it lies in its range."""
        return self._bounds[0] <= self.value <= self._bounds[1]

    def set_enabled(self, *, enabled: bool) -> None:
        """Let it be changed, or not."""
        if self._slider is not None and enabled != self._field.enabled:
            self._slider.props(
                add=None if enabled else "disabled", remove="disabled" if enabled else None
            )
        self._field.set_enabled(enabled)

    def _fault(self, given: float | None, unit: str) -> str | None:
        return outside(math.nan if given is None else given, self._bounds, unit)


def outside(given: float, bounds: tuple[float, float], unit: str) -> str | None:
    """Return the words on a number outside its range; None within it."""
    low, high = bounds
    return None if low <= given <= high else f"{low:g} to {high:g} {unit} is allowed".rstrip()


class OptionalNumber:
    """A number that may be left out; one outside its range is said at the field and not taken.

    Attributes
    ----------
    field
        The field itself.
    """

    def __init__(self, label: str, testid: str, bounds: tuple[float, float], unit: str) -> None:
        self._bounds, self._unit = bounds, unit
        self.field = ui.number(label, validation=self._fault)
        self.field.props(f"outlined dense hide-bottom-space data-testid={testid}")

    @property
    def value(self) -> float | None:
        """What the field holds; None where it is empty or outside its range."""
        given = self.field.value
        return None if given is None or self._fault(given) else float(given)

    @property
    def valid(self) -> bool:
        """Whether it is empty, or lies in its range."""
        return self._fault(self.field.value) is None

    def _fault(self, given: float | None) -> str | None:
        return None if given is None else outside(given, self._bounds, self._unit)


def _slider(
    about: Quantity, bounds: tuple[float, float], value: float, step: float, name: str
) -> ui.element:
    """Place a slider that writes into the number beside it; `fields.js` has it follow that."""
    slider = ui.element("input").classes("amount")
    # As a value it would be set anew with every other change of the page.
    slider.props(
        f"type=range min={bounds[0]:g} max={bounds[1]:g} step={step:g} defaultValue={value:g} "
        f'aria-label="{about.name}, slider" data-testid={name}-slider'
    )
    return slider.on("input", js_handler="(event) => window.slideField(event.target)")


class CampaignField:
    """The campaign that shots belong to; may be empty."""

    def __init__(self, value: str) -> None:
        with ui.element("div").classes("field"):
            with ui.element("div").classes("caption"):
                ui.label("Campaign").tooltip(
                    "Shots of one campaign are fitted together. A shot by itself needs none."
                )
                ui.label("letters, digits, . _ -")
            self._field = ui.input(
                value=value,
                validation=lambda given: (
                    None if _names_campaign(given) else "letters, digits, . _ - only, up to 64"
                ),
            ).props('outlined dense hide-bottom-space aria-label="Campaign" data-testid=campaign')

    @property
    def value(self) -> str:
        """What the field holds."""
        return (self._field.value or "").strip()

    @property
    def valid(self) -> bool:
        """Whether it can be a campaign's name."""
        return _names_campaign(self.value)

    def set_enabled(self, *, enabled: bool) -> None:
        """Let it be changed, or not."""
        self._field.set_enabled(enabled)


def setting_fields(limits: Limits, present: ShotSettings | None) -> dict[str, NumberField]:
    """Place a field for each setting that this apparatus has, by its name in `ShotSettings`."""
    ui.add_head_html(f"<script>{SCRIPT.read_text('utf-8')}</script>")
    fields: dict[str, NumberField] = {}
    for name, about in SETTINGS.items():
        bounds: tuple[float, float] | None = getattr(limits, _RANGES[name])
        if bounds is None:
            continue
        known = None if present is None else getattr(present, name)
        start = START.get(name, bounds[0]) if known is None else known
        # Settings that a sweep fired last are halves and thirds with all their places.
        start = round(min(max(start, bounds[0]), bounds[1]), PLACES)
        fields[name] = NumberField(about, bounds, start, name, step=STEPS.get(name))
    return fields


def _names_campaign(given: str | None) -> bool:
    try:
        return not given or bool(_CAMPAIGN.validate_python(given))
    except ValidationError:
        return False
