"""Campaigns: which there are, and the page of one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from nicegui import events, run, ui

from analysis.figures.palette import FAILS, FLOOR, MEASURED
from rigctl.documents import Json
from rigctl.errors import RigError
from rigctl.page.campaigns.output import Output
from rigctl.page.desk import Desk
from rigctl.page.layout import TICK_S, sheet
from rigctl.page.model.source import Source
from rigctl.page.model.state import Question
from rigctl.page.parts.empty_plots import READING
from rigctl.page.parts.following import following
from rigctl.page.parts.impact_plots import ERROR_BAR, HEIGHT, over_incidence, over_speed
from rigctl.page.parts.plots import figure
from rigctl.page.parts.presence import kept_page
from rigctl.page.parts.quantities import INCIDENCE, REBOUND, SPEED
from rigctl.page.parts.readings import Impact, rows_of
from rigctl.page.parts.remarks import Remarks
from rigctl.page.parts.waiting import Waiting
from rigctl.page.parts.widgets import button, plot, save_csv
from rigctl.page.shots.table import WHY, ShotTable, column, explain_headings, latest, link_cells
from rigctl.store import CampaignRecord, ShotRecord, ShotState


def plane(found: Json, title: str) -> Json:
    """Return v_s' / |v_n| over v_s / |v_n|: shots, Walton's two lines, Maw's curve."""
    reach = 1.08 * max([*found["x"], 0.1])
    laws = [
        _law("Walton, two lines", found, "walton", {"color": FAILS, "width": 2.2}),
        _law("Maw, Barber, Fawcett", found, "maw", {"color": FLOOR, "width": 2.2, "dash": "dash"}),
    ]
    shots = {
        "type": "scatter",
        "mode": "markers",
        "name": "shots",
        "x": found["x"],
        "y": found["y"],
        "error_y": {**ERROR_BAR, "array": found["sigma"]},
        "customdata": found["shots"],
        "marker": {"color": MEASURED, "size": 7},
        "hovertemplate": "shot %{customdata}: %{x:.3f}, %{y:.3f}<extra></extra>",
    }
    inside = [y for x, y in zip(found["law_x"], found["walton"], strict=True) if x <= reach]
    low, high = min([*inside, *found["y"]]), max([*inside, *found["y"]])
    room = 0.12 * (high - low)
    return figure(
        [*laws, shots],
        HEIGHT,
        f"{title}-figure-7-4",
        showlegend=True,
        legend={
            "x": 0.02,
            "y": 0.98,
            "bgcolor": "rgba(0,0,0,0)",
            "itemclick": False,
            "itemdoubleclick": False,
        },
        xaxis={
            "title": {"text": "v<sub>s</sub> / |v<sub>n</sub>| before contact"},
            "range": [0, reach],
        },
        yaxis={
            "title": {"text": "v<sub>s</sub>′ / |v<sub>n</sub>| after contact"},
            "range": [low - room, high + room],
        },
    )


def _law(name: str, found: Json, key: str, line: Json) -> Json:
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "x": found["law_x"],
        "y": found[key],
        "line": line,
        "hoverinfo": "skip",
    }


@dataclass(frozen=True, slots=True)
class _Stand:
    """A campaign at one moment."""

    record: CampaignRecord
    shots: list[ShotRecord]
    impacts: list[Impact]

    @property
    def counted(self) -> list[Impact]:
        """What the shots were measured to be that nobody excluded."""
        excluded = {shot.number for shot in self.shots if shot.excluded is not None}
        return [impact for impact in self.impacts if impact.number not in excluded]


class CampaignView:
    """Placed where it is made; its table and the plots of shots grow with each shot.

    The fit behind figure 7.4 is that of the shots measured when the page was opened, or when it
    was asked for again.
    """

    def __init__(self, desk: Desk, campaign: str) -> None:
        self._desk, self._campaign = desk, campaign
        self._heard = -1
        self._now: _Stand | None = None
        self._said = desk.daemon.store.campaigns.one(campaign)
        source = Source(desk.daemon, campaign)
        self._fitted = Question(lambda: source.ask("picture"), desk.daemon.jobs.job)
        self._fitted.start()
        with ui.element("div").classes("head"):
            self._head()
            ui.space()
            Output(desk, campaign)
            address = f"/model/{campaign}"
            button("Compare with the model", lambda: ui.navigate.to(address), testid="to-model")
        with ui.element("div").classes("panel").props("data-testid=remarks"):
            self._remarks()
        with ui.element("div").classes("columns third"):
            with ui.element("div").classes("panel tall").props("data-testid=figure-7-4"):
                self._plane()
                Waiting(desk, "Fitting the law", lambda: self._fitted.running or "", "fitting")
            with ui.element("div").classes("panel"):
                self._titled("Bounce over approach speed", "restitution", SPEED)
                self._speed = plot(over_speed([], campaign, READING)).props(
                    "data-testid=restitution"
                )
            with ui.element("div").classes("panel"):
                self._titled("Spin-back over sliding", "tangential", INCIDENCE)
                self._incidence = plot(over_incidence([], campaign, READING))
        with ui.element("div").classes("panel"):
            self._titled("Shots", "coefficients", "A click opens one.")
            self._table = ShotTable(measured=True)
        following(TICK_S * 3, self._follow)

    async def _follow(self) -> None:
        if self._fitted.follow():
            self._plane.refresh()
        heard = self._desk.feed.told
        if heard == self._heard:
            return
        stand = await run.io_bound(self._stand)
        if stand is None:
            return
        self._heard, before, self._now = heard, self._now, stand
        if before is None or stand != before:
            self._head.refresh()
            self._plane.refresh()
            self._table.show(stand.shots, stand.impacts)
        if _words(stand.record) != _words(self._said):
            self._said = stand.record
            self._remarks.refresh()
        if before is None or stand.counted != before.counted:
            self._speed.update_figure(over_speed(stand.counted, self._campaign))
            self._incidence.update_figure(over_incidence(stand.counted, self._campaign))

    def _stand(self) -> _Stand:
        """Read the campaign; blocks for the disk."""
        shots = latest(self._desk, self._campaign)
        record = self._desk.daemon.store.campaigns.one(self._campaign)
        return _Stand(record, shots, self._desk.readings.of(shots))

    @ui.refreshable_method
    def _head(self) -> None:
        ui.html(f"<h2>{self._campaign}</h2>", sanitize=True)
        if self._now is not None:
            ui.label(_counts(self._now.record)).classes("aside")

    @ui.refreshable_method
    def _remarks(self) -> None:
        with ui.element("div").classes("said-of"):
            Remarks(self._desk, *_words(self._said), self._annotate, self._tag).place()

    def _annotate(self, note: str | None, who: str) -> CampaignRecord:
        # What this page says itself is there already: drawn anew, its fields would lose the cursor.
        self._said = replace(self._said, note=note)
        return self._desk.daemon.store.annotate_campaign(self._campaign, note, who)

    def _tag(self, tags: Sequence[str], who: str) -> CampaignRecord:
        self._said = replace(self._said, tags=tuple(tags))
        return self._desk.daemon.store.tag_campaign(self._campaign, tags, who)

    @ui.refreshable_method
    def _plane(self) -> None:
        answer = self._fitted.answer
        with ui.element("div").classes("title"):
            ui.label("Rebound of the surface").tooltip(REBOUND)
            ui.label("figure 7.4").classes("aside")
            ui.space()
            if answer is not None:
                found: Json = answer["plane"]
                save_csv(f"{self._campaign}-figure-7-4", lambda: _plane_rows(found))
        if answer is not None:
            plot(plane(answer["plane"], self._campaign))
            self._aged(answer["shots"] + len(answer["rejected"]) + len(answer["excluded"]))
        elif self._fitted.failure:
            ui.label(self._fitted.failure).classes("empty")
            button("Fit again", self._refit, testid="refit")
        else:
            ui.label("Its law comes with the fit.").classes("empty")

    def _aged(self, fitted: int) -> None:
        """Say so where shots were measured since the fit."""
        measured = 0 if self._now is None else len(self._now.impacts)
        if measured > fitted:
            with ui.element("div").classes("beside"):
                ui.label(f"{measured - fitted} shots were measured since.").classes("note")
                button("Fit again", self._refit, testid="refit")

    def _refit(self) -> None:
        self._fitted.start()
        self._plane.refresh()

    def _titled(self, title: str, name: str, meaning: str) -> None:
        with ui.element("div").classes("title"):
            ui.label(title).tooltip(meaning)
            ui.space()
            save_csv(f"{self._campaign}-{name}", self._rows)

    def _rows(self) -> list[list[object]]:
        return rows_of([] if self._now is None else self._now.impacts)


def _words(campaign: CampaignRecord) -> tuple[str | None, tuple[str, ...]]:
    return campaign.note, campaign.tags


def _counts(campaign: CampaignRecord) -> str:
    states = ", ".join(f"{count} {state}" for state, count in campaign.states.items())
    return f"{campaign.shots} shot{'' if campaign.shots == 1 else 's'}: {states}"


def _plane_rows(found: Json) -> list[list[object]]:
    names = ("shots", "x", "y", "sigma")
    return [list(names), *map(list, zip(*(found[name] for name in names), strict=True))]


COLUMNS = [
    column("name", "campaign", "left"),
    column("shots", "shots"),
    column("measured", "measured"),
    column("refused", "refused"),
    column("other", "not analysed"),
    column("first", "first shot", "left"),
    column("last", "last shot", "left"),
    column("tags", "tags", "left"),
    column("note", "note", "left", **WHY),
]
HEADINGS = {
    "name": "Shots of one campaign are fitted together.",
    "shots": "All that were accepted under this name, whatever became of them.",
    "measured": "Shots that have coefficients.",
    "refused": "Shots whose frames could not be measured; each with the reason.",
    "other": "Shots under way, and those that came to nothing.",
    "first": "When the first shot was accepted.",
    "last": "When the latest shot was accepted.",
    "tags": "Words that a person gave it, to filter by.",
    "note": "What a person said of it.",
}


def campaign_pages(desk: Desk) -> None:
    """Register `/campaigns` and `/campaigns/{campaign}`."""

    @kept_page("/campaigns")
    def campaigns() -> None:
        with sheet(desk, "Campaigns", "/campaigns"), ui.element("div").classes("panel"):
            with ui.element("div").classes("title"):
                ui.label("Campaigns")
                ui.space()
                bring = button("Bring your own data", lambda: ui.navigate.to("/own"), testid="own")
                bring.tooltip("a film of a ball, or the tables of another laboratory")
            _listed(desk.daemon.store.campaigns.all())

    @kept_page("/campaigns/{campaign}")
    def one(campaign: str) -> None:
        with sheet(desk, f"Campaign {campaign}", "/campaigns"):
            try:
                desk.daemon.store.campaigns.one(campaign)
            except RigError as error:
                ui.label(error.sentence()).classes("verdict bad")
                ui.link("All campaigns", "/campaigns")
                return
            CampaignView(desk, campaign)


def _listed(found: list[CampaignRecord]) -> None:
    if not found:
        ui.label(
            "There is none yet: fire a shot on the page Rig with the field Campaign filled in, or "
            "run a sweep."
        ).classes("empty")
        return
    with ui.element("div").classes("beside"):
        given = ui.input(placeholder="Filter: a part of the name, a date …")
        given.props('outlined dense clearable data-testid=filter aria-label="Filter"')
        given.classes("filter")
    rows = [_row(campaign) for campaign in found]
    table = ui.table(rows=rows, columns=COLUMNS, pagination=20, row_key="name")
    table.props("dense flat data-testid=campaigns").classes("wide").bind_filter_from(given, "value")

    explain_headings(table, HEADINGS)
    link_cells(table, "name", "/campaigns/", "name")

    def open_one(event: events.GenericEventArguments) -> None:
        ui.navigate.to(f"/campaigns/{event.args[1]['name']}")

    table.on("rowClick", open_one)


def _row(campaign: CampaignRecord) -> dict[str, object]:
    measured = campaign.states.get(ShotState.ANALYSED, 0)
    refused = campaign.states.get(ShotState.REFUSED, 0)
    return {
        "name": campaign.name,
        "shots": campaign.shots,
        "measured": measured,
        "refused": refused,
        "other": campaign.shots - measured - refused,
        "first": f"{campaign.first_at.astimezone():%Y-%m-%d %H:%M}",
        "last": f"{campaign.last_at.astimezone():%Y-%m-%d %H:%M}",
        "tags": ", ".join(campaign.tags),
        "note": campaign.note or "",
    }
