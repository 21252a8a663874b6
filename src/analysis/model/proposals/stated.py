"""A form stated in full: what a later test on other shots needs, and from which shots it comes.

A file of one's own runs as code; a statement is numbers and names of what is known here, so that it
may come from anywhere, and holds forms of the launch too.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from analysis.errors import ProposalRefusedError
from analysis.model.data.poses import PoseData
from analysis.model.data.tables import ContactTable, Data
from analysis.model.proposals.arguments import (
    OF_PLACES,
    OF_SPINS,
    ON_BODIES,
    SPEEDS,
    Argument,
    column_argument,
)
from analysis.model.proposals.channels import Form
from analysis.model.proposals.forms.flight import FlightForm, flight_forms
from analysis.model.proposals.forms.form import SLOTS, ContactForm
from analysis.model.proposals.forms.frame import FrameForm, frame_forms
from analysis.model.proposals.forms.launch import QUANTITIES, LaunchForm
from analysis.model.proposals.forms.shapes import SHAPES, Shape
from analysis.model.proposals.proposed import Proposed
from analysis.motion.frame_notes import ranges

Json = dict[str, Any]

LAUNCH = "launch"
_LISTS: Mapping[str, Any] = MappingProxyType(
    dict.fromkeys(("arguments", "symbols", "columns", "beside"), str)
    | dict.fromkeys(("constants", "reach"), int | float)
)
_SHORT = re.compile(r"(\d+(-\d+)?(,\d+(-\d+)?)*)?")
Slot = Literal[
    "e", "mu", "beta0", "torsion", "impulse_n", "impulse_t", "flight", "camera", "clock", "launch"
]


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a form was chosen, as in `Statement`."""

    campaign: str
    shots: str
    beside: tuple[str, ...] = ()

    @classmethod
    def of(cls, campaign: str, proposed: Proposed) -> Origin:
        """Return where the forms of a campaign were chosen."""
        numbers = [int(number) for number in proposed.evidence.stated.shots]
        return cls(campaign, ranges(numbers), proposed.effects)


@dataclass(frozen=True, slots=True, kw_only=True)
class Statement:
    """One form, as documents and files hold it.

    Attributes
    ----------
    slot
        What changes.
    kind
        Of a force in flight, of the camera and of the clock; of the launch its quantity.
    arguments, symbols
        Names and symbols of what a coefficient or the launch follows.
    columns
        Expressions that say which shape it is; empty: the arguments' own numbers.
    constants
        Of the shape, or exponent, length or frequency.
    reach
        Largest size of each column over the shots that it was chosen on.
    along, by
        Axes of an error of the camera.
    campaign, shots
        Where it was chosen: numbers of the shots in short, `1-120,122`.
    beside
        Names of the effects that were fitted too when it was chosen.
    """

    slot: Slot
    kind: str = ""
    arguments: tuple[str, ...] = ()
    symbols: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    constants: tuple[float, ...] = ()
    reach: tuple[float, ...] = ()
    along: int = 0
    by: int = 0
    campaign: str = ""
    shots: str = ""
    beside: tuple[str, ...] = ()

    @classmethod
    def of(cls, form: Form | LaunchForm, origin: Origin) -> Statement:
        """State a form that was chosen on some shots of a campaign."""
        from_where = asdict(origin)
        if isinstance(form, FlightForm):
            return cls(slot="flight", kind=form.kind, constants=form.constants, **from_where)
        if isinstance(form, FrameForm):
            return cls(
                slot=form.slot,
                kind=form.kind,
                constants=form.constants,
                along=form.along,
                by=form.by,
                **from_where,
            )
        arguments = (form.of,) if isinstance(form, LaunchForm) else form.arguments
        return cls(
            slot=form.slot,  # type: ignore[arg-type]
            kind=form.quantity if isinstance(form, LaunchForm) else "",
            arguments=tuple(a.name for a in arguments),
            symbols=tuple(a.symbol for a in arguments),
            columns=() if form.shape is None else form.shape.codes,
            constants=form.constants,
            reach=() if isinstance(form, LaunchForm) else form.reach,
            **from_where,
        )

    @classmethod
    def read(cls, document: Mapping[str, Any]) -> Statement:
        """Read a document's `form`; other keys beside it are let be.

        Raises
        ------
        ProposalRefusedError
            It states no form.
        """
        own: dict[str, Any] = {}
        for name in cls.__slots__:
            if name in document:
                own[name] = _sound(name, document[name])
        if "slot" not in own:
            raise ProposalRefusedError("states no form: slot is missing")
        return cls(**own)

    def document(self) -> Json:
        """Return it as documents hold it."""
        found = {name: getattr(self, name) for name in self.__slots__}
        return {k: list(v) if isinstance(v, tuple) else v for k, v in found.items()}

    def form(self, data: Data) -> Form:
        """Return the form, for the shots of a campaign.

        Raises
        ------
        ProposalRefusedError
            It is none that is known, or the campaign has not what it follows.
        """
        if self.slot == "flight":
            return self._in_flight(data)
        if self.slot in {"camera", "clock"}:
            known = (f for f in frame_forms() if (f.slot, f.kind) == (self.slot, self.kind))
            for one in known:
                if (one.along, one.by) == (self.along, self.by):
                    return one.at(*self._constants(len(one.constants)))
            raise self._unknown("kind", self.kind)
        arguments = tuple(
            self._argument(name, symbol, data)
            for name, symbol in zip(self.arguments, self.symbols, strict=False)
        )
        shape = self.shape()
        if self.slot not in SLOTS or not 1 <= len(arguments) <= 2:
            raise self._unknown("arguments", ", ".join(self.arguments))
        columns = len(arguments[0].codes) if shape is None else len(shape.codes)
        columns = 1 if len(arguments) == 2 else columns
        constants = 0 if shape is None else len(shape.constants)
        constants = 2 if len(arguments) == 2 else constants
        reach = self.reach if len(self.reach) == columns else (1.0,) * columns
        return ContactForm(self.slot, arguments, shape, self._constants(constants), reach)

    def launch_form(self, data: Data, chosen: NDArray[np.bool_]) -> LaunchForm:
        """Return the form of the launch, for some shots of a campaign, mask of shape (S,).

        Raises
        ------
        ProposalRefusedError
            As of `form`.
        """
        shape = self.shape()
        if self.kind not in QUANTITIES or shape is None or len(self.arguments) != 1:
            raise self._unknown("kind", self.kind)
        name = self.arguments[0]
        if name not in data.covariates:
            raise self._missing(name)
        numbers = data.covariates[name][chosen]
        constants = self._constants(len(shape.constants))
        return LaunchForm(self.kind, column_argument(name, numbers), numbers, shape, constants)

    def shape(self) -> Shape | None:
        """Return its shape; None: the arguments' own numbers."""
        if not self.columns:
            return None
        for shape in SHAPES:
            if shape.codes == self.columns:
                return shape
        raise self._unknown("columns", "; ".join(self.columns))

    def _in_flight(self, data: Data) -> FlightForm:
        a, b = data.bodies
        if not isinstance(data, PoseData) or b.is_plate:
            raise ProposalRefusedError("a force in flight is seen in poses of two spheres alone")
        for one in flight_forms(a.radius + b.radius, a.mass):
            if one.kind == self.kind:
                return one.at(*self._constants(len(one.constants)))
        raise self._unknown("kind", self.kind)

    def _argument(self, name: str, symbol: str, data: Data) -> Argument:
        for one in (*SPEEDS, *OF_SPINS, *OF_PLACES, *ON_BODIES):
            if (one.name, one.symbol) == (name, symbol):
                if isinstance(data, ContactTable) and one not in SPEEDS:
                    spun = one in OF_SPINS and not data.scalars
                    if not spun:
                        raise self._missing(name)
                return one
        if name not in data.covariates:
            raise self._missing(name)
        return column_argument(name, data.covariates[name])

    def _constants(self, count: int) -> tuple[float, ...]:
        if len(self.constants) != count or not np.isfinite(self.constants).all():
            shown = ", ".join(f"{c:g}" for c in self.constants)
            raise ProposalRefusedError(
                f"the form has {count} constants, and the statement gives {shown or 'none'}"
            )
        return tuple(map(float, self.constants))

    def _unknown(self, key: str, value: str) -> ProposalRefusedError:
        return ProposalRefusedError(f"states no form of {self.slot}: {key} is {value!r}")

    def _missing(self, name: str) -> ProposalRefusedError:
        return ProposalRefusedError(
            f"{name}, which the form follows, is not known of every shot: add it to the shot list"
        )


def _sound(name: str, value: object) -> object:
    """Return a key's value as a statement holds it; refuse one of another type."""
    if name in _LISTS:
        kind = _LISTS[name]
        if isinstance(value, list | tuple) and all(
            isinstance(one, kind) and not isinstance(one, bool) for one in value
        ):
            return tuple(value)
    elif name in {"along", "by"}:
        if value in (0, 1, 2):
            return value
    elif isinstance(value, str) and (name != "shots" or _SHORT.fullmatch(value)):
        return value
    raise ProposalRefusedError(f"states no form: {name} is {value!r}")


def numbers_among(short: str, numbers: NDArray[np.intp]) -> set[int]:
    """Return which of some numbers stand in a list like `1-120,122`."""
    ends = [part.partition("-") for part in short.split(",") if part]
    within = [(int(low), int(high or low)) for low, _, high in ends]
    return {int(n) for n in numbers if any(low <= n <= high for low, high in within)}


def read_statement(path: Path) -> Statement:
    """Read a file that states a form.

    Raises
    ------
    ProposalRefusedError
        It cannot be read, or states no form.
    """
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ProposalRefusedError(f"{path} cannot be read: {error}") from error
    if not isinstance(document, dict) or not isinstance(document.get("form"), dict):
        raise ProposalRefusedError(f"{path} states no form: it has no object of the name form")
    return Statement.read(document["form"])
