"""Effects that the model may contain."""

from __future__ import annotations

from typing import Self

from fastapi import APIRouter
from pydantic import BaseModel, Field
from starlette.responses import Response

from analysis.effects.effect import Effect
from rigctl.daemon import Daemon
from rigctl.errors import NotFoundError
from rigctl.jobs import in_process
from rigctl.model.known_effects import ALL_EFFECTS, effect_document, effect_named
from rigctl.model.own_effects import PART, OwnEffects
from rigctl.service.accepted import accepts, answered
from rigctl.service.campaign_models import EffectName
from rigctl.service.problems import documented

READING = "rigctl.model.own_effects:reading_job"
_OWN = (401, 404, 405, 409)


class ParameterView(BaseModel):
    """One parameter of an effect: its plausible range, and the value where the effect is off."""

    symbol: str
    unit: str
    meaning: str
    plausible: tuple[float, float]
    off: float
    one_sided: bool


class EffectView(BaseModel):
    """One effect: its physics, its source, and its signature."""

    effect: str
    title: str
    stage: str
    parameters: list[ParameterView]
    formula: str
    source: str
    gives_away: str
    confused_with: list[str]
    variants: list[str] = Field(description="titles of the same effect with other fixed values")

    @classmethod
    def of(cls, effect: Effect) -> Self:
        """Return an effect as REST shows it."""
        return cls.model_validate(effect_document(effect))


class OwnEffectView(EffectView):
    """One effect of the user's own, and its file."""

    file: str


class FaultView(BaseModel):
    """What keeps a file of the user's from being used; lines count from 1."""

    path: str
    line: int
    effect: str
    what: str
    todo: str


class OwnEffectList(BaseModel):
    """What the configured folder of effects holds."""

    folder: str
    effects: list[OwnEffectView]
    faults: list[FaultView]


class EffectList(BaseModel):
    """The effects that poses can show, in the order of their stages, and those of the launch."""

    effects: list[EffectView]


def effect_routes(daemon: Daemon) -> APIRouter:
    """Return the routes below `/effects`."""
    router = APIRouter(prefix="/effects", tags=["effects"])

    @router.get("", responses=documented(401, 405))
    def effects() -> EffectList:
        """List the effects of the catalogue."""
        return EffectList(effects=[EffectView.of(effect) for effect in ALL_EFFECTS])

    @router.get("/own", response_model=OwnEffectList, responses=accepts() | documented(*_OWN))
    def own() -> Response:
        """Show the effects of the user's own, and what is wrong with those that are of no use.

        202 with a job until it is computed; the same request then returns the answer.
        """
        folder = OwnEffects.of(daemon.configuration)
        request = folder.asked()
        if not request:
            raise NotFoundError(
                "no folder with effects of your own is named",
                part=PART,
                todo="name one in the configuration, or start rigctl serve --effects FOLDER",
            )
        work = in_process(READING, request)
        named = ("own", str(folder.folder), folder.fingerprint())
        return answered(daemon.jobs.submit("own", "", work, named))

    @router.get("/{effect}", responses=documented(401, 404, 405, 422))
    def effect(effect: EffectName) -> EffectView:
        """Show one effect; 404 names those there are."""
        return EffectView.of(effect_named(effect, ALL_EFFECTS))

    return router
