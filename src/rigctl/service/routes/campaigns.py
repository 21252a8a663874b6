"""Campaigns: which there are, how their shots stand, and analysing them once more."""

from __future__ import annotations

from functools import partial
from typing import Annotated

from fastapi import APIRouter, Query
from starlette.responses import Response

from rigctl.daemon import Daemon
from rigctl.measuring.reanalysing import analysed_before, reanalysis
from rigctl.plain_text import CampaignName
from rigctl.service.accepted import accepted, accepts
from rigctl.service.campaign_models import (
    CampaignList,
    CampaignQuery,
    CampaignView,
    ReanalyseQuery,
)
from rigctl.service.problems import documented

PATIENCE_S = 60.0
"""Beyond the longest analysis."""


def campaign_routes(daemon: Daemon) -> APIRouter:
    """Return the routes below `/campaigns` that are of shots."""
    router = APIRouter(prefix="/campaigns", tags=["campaigns"])

    @router.get("", responses=documented(401, 405, 422, 503))
    def campaigns(query: Annotated[CampaignQuery, Query()]) -> CampaignList:
        """List all campaigns, or those with a tag, the one with the latest shot first."""
        found = daemon.store.campaigns.all(query.tag)
        return CampaignList(campaigns=[CampaignView.of(record) for record in found])

    @router.get("/{campaign}", responses=documented(401, 404, 405, 422, 503))
    def campaign(campaign: CampaignName) -> CampaignView:
        """Show one campaign."""
        return CampaignView.of(daemon.store.campaigns.one(campaign))

    @router.post(
        "/{campaign}/reanalyse",
        status_code=202,
        responses=accepts() | documented(401, 404, 405, 409, 411, 413, 422, 503),
    )
    def reanalyse(campaign: CampaignName, query: Annotated[ReanalyseQuery, Query()]) -> Response:
        """Analyse every shot again whose analysis has ended; results are added, none is lost."""
        shots = analysed_before(daemon.store, campaign)
        patience_s = daemon.configuration.analysis.timeout_s + PATIENCE_S
        analyse = daemon.analyse
        if (method := query.method) is not None:
            analyse = partial(_by, daemon, method)
        work = reanalysis(daemon.store, analyse, shots, patience_s)
        return accepted(daemon.jobs.submit("reanalyse", campaign, work))

    return router


def _by(daemon: Daemon, method: str, shot: str) -> None:
    daemon.analyse_by(shot, method)
