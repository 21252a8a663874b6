"""The bounce law as it was fitted, in three numbers; what is not believed is marked."""

from __future__ import annotations

from nicegui import ui

from rigctl.documents import Json
from rigctl.page.model.compare import is_unexpected
from rigctl.page.model.story.errors import three_figures
from rigctl.page.parts.quantities import EXPECTED
from rigctl.page.parts.tables import minus

NAMES = {
    "e": ("bounce e", "speed of parting over speed of approach"),
    "mu": ("friction μ", "push along the surfaces over push along the line of centres"),
    "beta0": ("spin-back β₀", "share of the sliding that is turned round where the surfaces stick"),
}


def law(found: Json) -> None:
    """Place the numbers of the law that an answer has, with a mark at one beyond its range."""
    with ui.element("div").classes("law").props("data-testid=law"):
        for name, (title, meaning) in NAMES.items():
            value = found["parameters"].get(name)
            if value is None or value["value"] is None:
                continue
            unexpected = is_unexpected(value, EXPECTED[name])
            with ui.element("div").classes("unbelieved" if unexpected else "").tooltip(meaning):
                ui.label(title).classes("note")
                said = minus(three_figures(value["value"]))
                ui.label(f"▲ {said}" if unexpected else said).classes("law-value")
                if unexpected:
                    low, high = EXPECTED[name]
                    ui.label(
                        minus(f"believed from {low:g} to {high:g}: something missing may hide here")
                    ).classes("note fails")
