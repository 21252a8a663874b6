"""Campaigns and their fits in REST, and the bodies of requests on them."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    Discriminator,
    Field,
    StringConstraints,
    Tag,
)

from rigctl.config.model import StrictModel
from rigctl.plain_text import CampaignName
from rigctl.plain_text import Tag as Word
from rigctl.service.forms import Query, View
from rigctl.store import CampaignRecord, ShotState

MOST_EFFECTS, MOST_CAMPAIGNS = 8, 32

EffectName = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9-]{0,63}$")]
"""The form of an effect's name; whether there is such an effect is another question."""

FitName = CampaignName
"""The name of a fit, which is part of a file's name."""


ParameterName = Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_.-]{0,127}$")]
"""A parameter of the fit: e, mu, beta0, or an effect's symbol after its name and a point."""


def _each_once(names: list[str]) -> list[str]:
    if len(set(names)) < len(names):
        raise ValueError("a name stands twice")
    return names


Effects = Annotated[
    list[EffectName],
    AfterValidator(_each_once),
    Field(default_factory=list, max_length=MOST_EFFECTS, json_schema_extra={"uniqueItems": True}),
]


Pair = Annotated[
    list[EffectName],
    AfterValidator(_each_once),
    Field(min_length=2, max_length=2, json_schema_extra={"uniqueItems": True}),
]


Together = Annotated[
    list[CampaignName],
    AfterValidator(_each_once),
    Field(max_length=MOST_CAMPAIGNS, json_schema_extra={"uniqueItems": True}),
]


class EffectsQuery(Query):
    """Effects of the catalogue that are added to the base model, in their order."""

    effects: Effects = Field(alias="with")


class ReanalyseQuery(Query):
    """By which method; without it the configuration's."""

    method: Literal["thesis", "photometric"] | None = None


class FitOrder(StrictModel):
    """Fit the base model with these effects and save the fit under a name."""

    name: FitName
    effects: Effects = Field(alias="with")


Words = Annotated[str, StringConstraints(max_length=200)]


class StatedForm(StrictModel):
    """One form in full, as `form` of a proposal states it, to be tested on other shots."""

    slot: Literal[
        "e",
        "mu",
        "beta0",
        "torsion",
        "impulse_n",
        "impulse_t",
        "flight",
        "camera",
        "clock",
        "launch",
    ]
    kind: Words = ""
    arguments: list[Words] = Field(default_factory=list, max_length=2)
    symbols: list[Words] = Field(default_factory=list, max_length=2)
    columns: list[Words] = Field(default_factory=list, max_length=2)
    constants: list[float] = Field(default_factory=list, max_length=4)
    reach: list[Annotated[float, Field(gt=0)]] = Field(default_factory=list, max_length=3)
    along: Literal[0, 1, 2] = 0
    by: Literal[0, 1, 2] = 0
    campaign: Words = ""
    shots: Annotated[
        str, StringConstraints(pattern=r"^([0-9]{1,9}(-[0-9]{1,9})?(,[0-9]{1,9}(-[0-9]{1,9})?)*)?$")
    ] = ""
    beside: list[Words] = Field(default_factory=list, max_length=64)


class LawOrder(StrictModel):
    """Propose a law that no catalogue holds, beside these effects; or what campaigns share."""

    effects: Effects = Field(alias="with")
    together: Together = Field(default_factory=list)

    def asked(self) -> dict[str, Any]:
        """Return the question as the job takes it, campaigns by their names."""
        return {"together": list(self.together)} if self.together else {}


class ConfirmOrder(StrictModel):
    """Test one form, beside these effects, on the shots that it was not chosen on."""

    effects: Effects = Field(alias="with")
    confirm: StatedForm

    def asked(self) -> dict[str, Any]:
        """Return the question as the job takes it."""
        return {"confirm": self.confirm.model_dump()}


def _kind_of_law(order: object) -> str:
    confirms = isinstance(order, ConfirmOrder) or (isinstance(order, dict) and "confirm" in order)
    return "confirm" if confirms else "propose"


ProposeOrder = Annotated[
    Annotated[LawOrder, Tag("propose")] | Annotated[ConfirmOrder, Tag("confirm")],
    Discriminator(_kind_of_law),
]
"""Either question about laws."""


class TellOrder(StrictModel):
    """Choose shots that distinguish two effects; without `between`, the verdict's alias set."""

    between: Pair | None = None
    probability: float = Field(default=0.9, ge=0.55, le=0.999)
    effects: Effects = Field(alias="with")

    def asked(self) -> dict[str, Any]:
        """Return the question as the job takes it."""
        return {**self.model_dump(include={"between", "probability"}), "sharpen": None, "to": None}


class SharpenOrder(StrictModel):
    """Choose shots that make a parameter of the fit surer."""

    sharpen: ParameterName
    to: float | None = Field(default=None, gt=0)
    effects: Effects = Field(alias="with")

    def asked(self) -> dict[str, Any]:
        """Return the question as the job takes it."""
        named = self.model_dump(include={"sharpen", "to"})
        return {**named, "between": None, "probability": 0.9}


def _kind_of_next(order: object) -> str:
    sharpens = isinstance(order, SharpenOrder) or (isinstance(order, dict) and "sharpen" in order)
    return "sharpen" if sharpens else "tell"


NextOrder = Annotated[
    Annotated[TellOrder, Tag("tell")] | Annotated[SharpenOrder, Tag("sharpen")],
    Discriminator(_kind_of_next),
]
"""Either question about next shots."""


class FitQuery(Query):
    """Which version of a fit; without it the latest."""

    version: int | None = Field(default=None, ge=1, le=1_000_000)


class CampaignQuery(Query):
    """Which campaigns to list; without a tag all."""

    tag: Word | None = None


class CampaignView(View):
    """A campaign: its shots by state, and when its first and last were accepted (UTC)."""

    campaign: str
    shots: int
    states: dict[ShotState, int] = Field(description="states without a shot are left out")
    excluded: int = Field(description="how many of its shots are left out of every fit")
    note: str | None
    tags: list[str]
    first_at: datetime
    last_at: datetime

    @classmethod
    def of(cls, record: CampaignRecord) -> Self:
        """Return a record as REST shows it."""
        return cls.showing(record, campaign=record.name)


class CampaignList(BaseModel):
    """All campaigns, the one with the latest shot first."""

    campaigns: list[CampaignView]


class FitView(BaseModel):
    """One version of a saved fit."""

    name: str
    version: int
    fit: dict[str, Any]


class FitReference(BaseModel):
    """Name and version of a saved fit."""

    name: str
    version: int


class FitList(BaseModel):
    """The saved fits of a campaign, by name and version."""

    fits: list[FitReference]
