"""Afterwards: leave a shot out of every fit, let it count again; note and tag shots, campaigns."""

from __future__ import annotations

from fastapi import APIRouter, Request

from rigctl.daemon import Daemon
from rigctl.plain_text import CampaignName
from rigctl.service.campaign_models import CampaignView
from rigctl.service.guards.requests import StrictRoute
from rigctl.service.models import ExcludeOrder, NoteOrder, ShotView, TagsOrder
from rigctl.service.problems import documented

_ORDER = (401, 404, 405, 411, 413, 422, 503)


def edit_routes(daemon: Daemon) -> APIRouter:
    """Return the routes below `/shots/{shot}` that change what is known of a shot."""
    router = APIRouter(prefix="/shots/{shot}", tags=["shots"], route_class=StrictRoute)
    store = daemon.store

    @router.post("/exclude", responses=documented(*_ORDER))
    def exclude(shot: str, order: ExcludeOrder, request: Request) -> ShotView:
        """Leave a shot out of every fit; nothing of it is deleted."""
        return ShotView.of(store.exclude(shot, order.reason, request.state.actor))

    @router.post("/include", responses=documented(401, 404, 405, 422, 503))
    def include(shot: str, request: Request) -> ShotView:
        """Let a shot count again."""
        return ShotView.of(store.include(shot, request.state.actor))

    @router.put("/note", responses=documented(*_ORDER))
    def note(shot: str, order: NoteOrder, request: Request) -> ShotView:
        """Put a note in the place of a shot's note, or take it away."""
        return ShotView.of(store.annotate(shot, order.note, request.state.actor))

    @router.put("/tags", responses=documented(*_ORDER))
    def tags(shot: str, order: TagsOrder, request: Request) -> ShotView:
        """Give a shot exactly these tags."""
        return ShotView.of(store.tag(shot, order.tags, request.state.actor))

    return router


def campaign_edit_routes(daemon: Daemon) -> APIRouter:
    """Return the routes below `/campaigns/{campaign}` that change its note and tags."""
    router = APIRouter(prefix="/campaigns/{campaign}", tags=["campaigns"], route_class=StrictRoute)
    store = daemon.store

    @router.put("/note", responses=documented(*_ORDER))
    def note(campaign: CampaignName, order: NoteOrder, request: Request) -> CampaignView:
        """Put a note in the place of a campaign's note, or take it away."""
        actor = request.state.actor
        return CampaignView.of(store.annotate_campaign(campaign, order.note, actor))

    @router.put("/tags", responses=documented(*_ORDER))
    def tags(campaign: CampaignName, order: TagsOrder, request: Request) -> CampaignView:
        """Give a campaign exactly these tags."""
        return CampaignView.of(store.tag_campaign(campaign, order.tags, request.state.actor))

    return router
