"""Effects: what the model can be asked to have in it."""

from __future__ import annotations

from typing import Self

from fastapi import APIRouter
from pydantic import BaseModel, Field

from analysis.effects.effect import Effect, Parameter
from rigctl.known_effects import ALL_EFFECTS, effect_named
from rigctl.service.campaign_models import EffectName
from rigctl.service.problems import documented


class ParameterView(BaseModel):
    """One number of an effect: where it is believed, and where the effect is off."""

    symbol: str
    unit: str
    meaning: str
    plausible: tuple[float, float]
    off: float
    one_sided: bool

    @classmethod
    def of(cls, parameter: Parameter) -> Self:
        """Return a parameter as REST shows it."""
        return cls(
            symbol=parameter.symbol,
            unit=parameter.unit,
            meaning=parameter.meaning,
            plausible=parameter.plausible,
            off=parameter.off,
            one_sided=parameter.one_sided,
        )


class EffectView(BaseModel):
    """One effect: its physics, its source, and what betrays it."""

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
        return cls(
            effect=effect.name,
            title=effect.title,
            stage=effect.stage,
            parameters=[ParameterView.of(each) for each in effect.parameters],
            formula=effect.formula,
            source=effect.source,
            gives_away=effect.gives_away,
            confused_with=list(effect.confused_with),
            variants=[variant.title for variant in effect.variants],
        )


class EffectList(BaseModel):
    """The effects that poses can show, in the order of their stages, and those of the launch."""

    effects: list[EffectView]


def effect_routes() -> APIRouter:
    """Return the routes below `/effects`."""
    router = APIRouter(prefix="/effects", tags=["effects"])

    @router.get("", responses=documented(401, 405))
    def effects() -> EffectList:
        """List the effects of the catalogue."""
        return EffectList(effects=[EffectView.of(effect) for effect in ALL_EFFECTS])

    @router.get("/{effect}", responses=documented(401, 404, 405, 422))
    def effect(effect: EffectName) -> EffectView:
        """Show one effect; 404 names those there are."""
        return EffectView.of(effect_named(effect, ALL_EFFECTS))

    return router
