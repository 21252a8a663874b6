"""Campaigns: which there are, and one with its shots, figure 7.4 and restitution over speed."""

from __future__ import annotations

from typing import Any

from nicegui import ui

from rigctl.errors import RigError
from rigctl.page.campaign_plots import plane, restitution
from rigctl.page.desk import Desk
from rigctl.page.layout import TICK_S, sheet
from rigctl.page.model_state import Question
from rigctl.page.shot_pages import latest, shot_table
from rigctl.page.shot_view import result_of
from rigctl.page.source import Source
from rigctl.page.widgets import plot, save_csv
from rigctl.store import CampaignRecord, ShotState

Json = dict[str, Any]


def campaign_pages(desk: Desk) -> None:
    """Register `/campaigns` and `/campaigns/{campaign}`."""

    @ui.page("/campaigns")
    def campaigns() -> None:
        with sheet(desk, "Campaigns", "/campaigns"), ui.element("div").classes("panel"):
            ui.label("Campaigns").classes("title")
            found = desk.daemon.store.campaigns.all()
            if not found:
                ui.label(
                    "There is none yet: fire a shot on the page Rig with the field Campaign filled "
                    "in, or run a sweep."
                ).classes("empty")
            for campaign in found:
                _listed(campaign)

    @ui.page("/campaigns/{campaign}")
    def one(campaign: str) -> None:
        with sheet(desk, f"Campaign {campaign}", "/campaigns"):
            try:
                record = desk.daemon.store.campaigns.one(campaign)
            except RigError as error:
                ui.label(error.sentence()).classes("verdict bad")
                return
            with ui.element("div").classes("head"):
                ui.label(record.name).classes("title")
                ui.label(_counts(record)).classes("aside")
                ui.space()
                ui.link("compare with the model", f"/model/{record.name}")
            _Plots(desk, campaign)
            with ui.element("div").classes("panel"):
                ui.label("Shots").classes("title")
                shot_table(latest(desk, campaign))


def _listed(campaign: CampaignRecord) -> None:
    with ui.element("div").classes("beside"):
        ui.link(campaign.name, f"/campaigns/{campaign.name}")
        ui.label(_counts(campaign)).classes("aside")
        ui.space()
        ui.label(f"last shot {campaign.last_at.astimezone():%Y-%m-%d %H:%M}").classes("aside")
        ui.link("model", f"/model/{campaign.name}")


def _counts(campaign: CampaignRecord) -> str:
    states = ", ".join(f"{count} {state}" for state, count in campaign.states.items())
    return f"{campaign.shots} shots: {states}"


class _Plots:
    """Figure 7.4 from the fit, and restitution over speed from the shots' own coefficients."""

    def __init__(self, desk: Desk, campaign: str) -> None:
        self._desk, self._campaign = desk, campaign
        source = Source(desk.daemon, campaign)
        self._fitted = Question(lambda: source.ask("picture"), desk.daemon.jobs.job)
        self._fitted.start()
        with ui.element("div").classes("columns half"):
            with ui.element("div").classes("panel"):
                self._plane()
            with ui.element("div").classes("panel"):
                self._restitution()
        ui.timer(TICK_S, self._follow)

    def _follow(self) -> None:
        if self._fitted.follow():
            self._plane.refresh()

    @ui.refreshable_method
    def _plane(self) -> None:
        answer = self._fitted.answer
        with ui.element("div").classes("title"):
            ui.label("Rebound of the surface velocity")
            ui.label("figure 7.4 of the thesis").classes("aside")
            ui.space()
            if answer is not None:
                found: Json = answer["plane"]
                names = ("shots", "x", "y", "sigma")
                columns = zip(*(found[name] for name in names), strict=True)
                rows = [list(names), *map(list, columns)]
                save_csv(f"{self._campaign}-figure-7-4", lambda: rows)
        if answer is not None:
            plot(plane(answer["plane"], self._campaign))
        elif self._fitted.failure:
            ui.label(self._fitted.failure).classes("empty")
        else:
            ui.label("Fitting …").classes("empty")

    def _restitution(self) -> None:
        found = [
            (shot.number, result["v_n"], result["e"])
            for shot in latest(self._desk, self._campaign)
            if shot.state is ShotState.ANALYSED
            and (result := result_of(self._desk, shot)).get("status") == "measured"
        ]
        rows: list[list[object]] = [["shot", "v_n, m/s", "e", "sigma of e"]]
        rows += [[n, v["value"], e["value"], e["sigma"]] for n, v, e in found]
        with ui.element("div").classes("title"):
            ui.label("Restitution over approach speed")
            ui.space()
            save_csv(f"{self._campaign}-restitution", lambda: rows)
        if found:
            plot(restitution(found, self._campaign))
        else:
            ui.label("No shot of this campaign is measured yet.").classes("empty")
