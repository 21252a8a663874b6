"""The model against a campaign: long work is a job, whose result the same request then returns."""

from __future__ import annotations

import json
from collections.abc import Hashable, Sequence
from typing import Annotated

from fastapi import APIRouter, Query
from starlette.responses import Response

from analysis.schema.agreement import AgreementReport, StructureReport
from analysis.schema.verdict import FitReport, RankedCandidate
from rigctl.daemon import Daemon
from rigctl.documents import Json
from rigctl.jobs import Job, Task, Work, in_process
from rigctl.measuring.measured import measured_files, others, request
from rigctl.model import FUNCTIONS
from rigctl.model.own_effects import OwnEffects
from rigctl.plain_text import CampaignName
from rigctl.service.accepted import accepted, accepts, answered
from rigctl.service.campaign_models import (
    EffectsQuery,
    FitList,
    FitName,
    FitOrder,
    FitQuery,
    FitReference,
    FitView,
    NextOrder,
    ProposeOrder,
)
from rigctl.service.guards.requests import StrictRoute
from rigctl.service.openapi import reported
from rigctl.service.problems import documented


def model_routes(daemon: Daemon) -> APIRouter:
    """Return the routes below `/campaigns` that are of the model."""
    router = APIRouter(prefix="/campaigns/{campaign}", tags=["model"], route_class=StrictRoute)

    @router.get("/agreement", responses=_AGREEMENT | accepts() | documented(*_QUESTION))
    def agreement(campaign: CampaignName, query: Annotated[EffectsQuery, Query()]) -> Response:
        """Compare the model with the campaign by stage and quantity.

        202 with a job until it is computed; the same request then returns the answer.
        """
        return answered(_ask(daemon, "agreement", campaign, query.effects))

    @router.get("/structure", responses=_STRUCTURE | accepts() | documented(*_QUESTION))
    def structure(campaign: CampaignName, query: Annotated[EffectsQuery, Query()]) -> Response:
        """Test what the model leaves over, with the residuals where most is left.

        202 with a job until it is computed; the same request then returns the answer.
        """
        return answered(_ask(daemon, "structure", campaign, query.effects))

    @router.get("/ranking", responses=_RANKING | accepts() | documented(*_QUESTION))
    def ranking(campaign: CampaignName, query: Annotated[EffectsQuery, Query()]) -> Response:
        """Rank the effects of the catalogue by their score tests.

        202 with a job until it is computed; the same request then returns the answer.
        """
        return answered(_ask(daemon, "ranking", campaign, query.effects))

    @router.post("/explain", status_code=202, responses=accepts() | documented(*_POST))
    def explain(campaign: CampaignName) -> Response:
        """Find what is missing, to a verdict."""
        return accepted(_ask(daemon, "explain", campaign, []))

    @router.post("/propose", status_code=202, responses=accepts() | documented(*_POST))
    def propose(campaign: CampaignName, order: ProposeOrder) -> Response:
        """Propose the law that no catalogue holds, beside the effects named.

        Or what several campaigns share, or whether other shots confirm one form.
        """
        limits, asked = daemon.configuration.limits, order.asked()
        asked["limits"] = [limits.pressure_kpa, limits.offset_mm]
        if "together" in asked:
            asked["together"] = others(daemon.store, campaign, asked["together"])
        return accepted(_ask(daemon, "propose", campaign, order.effects, asked))

    @router.post("/next", status_code=202, responses=accepts() | documented(*_POST))
    def next_shots(campaign: CampaignName, order: NextOrder) -> Response:
        """Choose the next shots: to distinguish two effects, or to sharpen a parameter."""
        # The daemon starts without loading the model.
        from analysis.model.design.document import NONE  # noqa: PLC0415

        asked = order.asked()
        OwnEffects.of(daemon.configuration).require(set(asked["between"] or ()) - {NONE})
        limits = daemon.configuration.limits
        asked["limits"] = [limits.pressure_kpa, limits.offset_mm]
        return accepted(_ask(daemon, "next", campaign, order.effects, asked))

    @router.post("/fits", status_code=202, responses=accepts() | documented(*_POST))
    def fit(campaign: CampaignName, order: FitOrder) -> Response:
        """Fit, and save the fit under a name; a name that is known gets a further version."""
        work = _saved(daemon, order.name, _work(daemon, "fit", campaign, order.effects)[0])
        return accepted(daemon.jobs.submit("fits", campaign, work))

    @router.get("/fits", responses=documented(*_GET))
    def fits(campaign: CampaignName) -> FitList:
        """List the saved fits of a campaign."""
        daemon.store.campaigns.one(campaign)
        found = daemon.store.fits.versions(campaign)
        return FitList(fits=[FitReference(name=name, version=version) for name, version in found])

    @router.get("/fits/{fit}", responses=documented(*_GET))
    def saved(campaign: CampaignName, fit: FitName, query: Annotated[FitQuery, Query()]) -> FitView:
        """Show a saved fit, the latest version of its name or the requested one."""
        version, document = daemon.store.fits.fit(campaign, fit, query.version)
        return FitView(name=fit, version=version, fit=document)

    return router


# Its `noise` has an error beside each factor: not that of a fit, whose other keys stand beside.
_AGREEMENT = reported(AgreementReport)
_STRUCTURE = reported(FitReport, parts={"structure": StructureReport})
_RANKING = reported(FitReport, lists={"candidates": RankedCandidate})
_GET = (401, 404, 405, 422, 503)
_QUESTION = (401, 404, 405, 409, 422, 503)
_POST = (401, 404, 405, 409, 411, 413, 422, 503)


def _work(
    daemon: Daemon, kind: str, campaign: str, effects: Sequence[str], more: Json | None = None
) -> tuple[Work, Sequence[Hashable]]:
    """Return work on the shots as they are measured now, and what names exactly this work."""
    own = OwnEffects.of(daemon.configuration)
    own.require(effects)
    files = measured_files(daemon.store, campaign)
    asked = request(campaign, files, effects, daemon.store) | own.asked() | (more or {})
    work = in_process(f"{FUNCTIONS}:{kind}_job", asked)
    return work, (json.dumps(more), own.fingerprint(), *effects, *files)


def _ask(
    daemon: Daemon, kind: str, campaign: str, effects: Sequence[str], more: Json | None = None
) -> Job:
    """Return the job that answers a question, the one that did or does so already if there is."""
    work, named = _work(daemon, kind, campaign, effects, more)
    return daemon.jobs.submit(kind, campaign, work, (kind, campaign, *named))


def _saved(daemon: Daemon, name: str, fitting: Work) -> Work:
    """Return work that fits and saves what came of it."""

    def work(task: Task) -> str:
        document = json.loads(fitting(task))
        version = daemon.store.fits.add(str(document["campaign"]), name, document)
        return json.dumps({"name": name, "version": version, **document})

    return work
