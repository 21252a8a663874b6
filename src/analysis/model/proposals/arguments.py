"""What a coefficient of the contact may depend on: numbers of an encounter, and their code.

Each is given twice: as a function, and as the expression that an effect file holds. A test keeps
them one.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.collision.operator import Encounter

LEAST_SPEED, LARGEST_RATIO = 0.01, 20.0
"""m/s; slower contacts have no direction of slip, and a ratio beyond this decides by itself."""
ORDER = "order"
_SETTING = re.compile(r"pressure_\w+_kpa|offset_mm|delay_us")


@dataclass(frozen=True, slots=True, eq=False)
class Argument:
    """One number of each encounter, or several that belong together.

    Attributes
    ----------
    name
        As documents have it.
    symbol, latex, unit
        As a formula has it; a unit that is not known is "1".
    codes
        Expressions in `encounter`, one for each number.
    of
        The numbers, shape (S, numbers).
    positive
        Whether it is never below zero and its logarithm means something.
    """

    name: str
    symbol: str
    latex: str
    unit: str
    codes: tuple[str, ...]
    of: Callable[[Encounter], Floats]
    positive: bool = False

    @property
    def is_scalar(self) -> bool:
        """Whether it is one number."""
        return len(self.codes) == 1

    @property
    def is_setting(self) -> bool:
        """Whether the rig sets it: it acts through how the spheres meet, and by nothing else."""
        return is_setting_name(self.name)

    @property
    def key(self) -> tuple[str, str]:
        """What tells it from others; a spin and its size share a name."""
        return self.name, self.symbol


def is_setting_name(name: str) -> bool:
    """Whether the rig sets the column of this name."""
    return _SETTING.fullmatch(name) is not None


def _approach(encounter: Encounter) -> Floats:
    return np.asarray(encounter.approach.clip(min=LEAST_SPEED)[:, None])


def _sliding(encounter: Encounter) -> Floats:
    return np.asarray(encounter.sliding_speed.clip(min=LEAST_SPEED)[:, None])


def _ratio(encounter: Encounter) -> Floats:
    return np.minimum(_sliding(encounter) / _approach(encounter), LARGEST_RATIO)


def _spin(encounter: Encounter) -> Floats:
    relative = encounter.before.spin_b - encounter.before.spin_a
    return np.asarray((relative * encounter.normal).sum(axis=1, keepdims=True))


def _spin_size(encounter: Encounter) -> Floats:
    return np.abs(_spin(encounter))


def _twice_angle(encounter: Encounter) -> Floats:
    x, y = encounter.normal[:, 0], encounter.normal[:, 1]
    return np.stack([y * y - x * x, 2 * x * y], axis=1) / (x * x + y * y)[:, None]


def _contact(axis: int) -> Callable[[Encounter], Floats]:
    def of(encounter: Encounter) -> Floats:
        assert encounter.point is not None  # noqa: S101 - offered for poses alone
        return encounter.point[:, axis : axis + 1]

    return of


def _place(body: int) -> Callable[[Encounter], Floats]:
    outward = 1.0 - 2.0 * body

    def of(encounter: Encounter) -> Floats:
        assert encounter.rotation is not None  # noqa: S101 - offered for poses alone
        place = np.einsum("sji,sj->si", encounter.rotation[:, body], outward * encounter.normal)
        return np.asarray(place)

    return of


def _column(name: str) -> Callable[[Encounter], Floats]:
    def of(encounter: Encounter) -> Floats:
        return encounter.covariates[name][:, None]

    return of


_SPEED_N = f"encounter.approach.clip(min={LEAST_SPEED})"
_SPEED_S = f"encounter.sliding_speed.clip(min={LEAST_SPEED})"
_SPIN = "((encounter.before.spin_b - encounter.before.spin_a) * encounter.normal).sum(axis=1)"
_X, _Y = "encounter.normal[:, 0]", "encounter.normal[:, 1]"
_ACROSS = f"({_X}**2 + {_Y}**2)"

SPEEDS: tuple[Argument, ...] = (
    Argument("speed_n", "v_n", "v_n", "m/s", (_SPEED_N,), _approach, positive=True),
    Argument("speed_s", "v_s", "v_s", "m/s", (_SPEED_S,), _sliding, positive=True),
    Argument(
        "obliquity",
        "v_s/v_n",
        r"\frac{v_s}{v_n}",
        "1",
        (f"np.minimum({_SPEED_S} / {_SPEED_N}, {LARGEST_RATIO})",),
        _ratio,
        positive=True,
    ),
)
OF_SPINS: tuple[Argument, ...] = (
    Argument("spin", "w_n", r"\omega_n", "rad/s", (_SPIN,), _spin),
    Argument("spin", "|w_n|", r"|\omega_n|", "rad/s", (f"np.abs({_SPIN})",), _spin_size),
    Argument(
        "normal",
        "2 phi",
        r"2\varphi",
        "1",
        (f"({_Y}**2 - {_X}**2) / {_ACROSS}", f"2 * {_X} * {_Y} / {_ACROSS}"),
        _twice_angle,
    ),
)
OF_PLACES: tuple[Argument, ...] = tuple(
    Argument(f"contact_{axis}", axis, axis, "m", (f"encounter.point[:, {k}]",), _contact(k))
    for k, axis in enumerate("xyz")
)
ON_BODIES: tuple[Argument, ...] = tuple(
    Argument(
        f"place_{name}",
        f"p_{name}",
        rf"\mathbf{{p}}_{name}",
        "1",
        tuple(
            f'{sign}np.einsum("sj,sj->s", encounter.rotation[:, {body}, :, {k}], encounter.normal)'
            for k in range(3)
        ),
        _place(body),
    )
    for body, (name, sign) in enumerate((("a", ""), ("b", "-")))
)

_UNITS = {
    "kpa": "kPa",
    "mm": "mm",
    "m": "m",
    "s": "s",
    "c": "K",
    "k": "K",
    "rad": "rad",
    "hz": "Hz",
}


def column_argument(name: str, values: Floats) -> Argument:
    """Return a column of the shot list as an argument; its unit is the last word of its name."""
    words, _, last = name.rpartition("_")
    unit = _UNITS.get(last, "1") if words else "1"
    symbol = "T" if words == "temperature" else name
    latex = symbol.replace("_", r"\_") if len(symbol) == 1 else rf"\mathrm{{{name}}}"
    # A ratio of temperatures in degrees has no meaning, nor has that of a place in the order.
    positive = name != ORDER and last != "c" and float(values.min()) > 0
    code = f'encounter.covariates["{name}"]'
    return Argument(
        name, symbol, latex.replace("_", r"\_"), unit, (code,), _column(name), positive=positive
    )


def _rank(name: str) -> tuple[bool, bool, str]:
    """Order columns: of two that are one and the same, the first is the one that is tested."""
    return name != ORDER, name.rpartition("_")[2] not in _UNITS, name


def is_column(argument: Argument) -> bool:
    """Whether an argument is a numeric column of the shot list, or the order of firing."""
    return argument.codes[0].startswith("encounter.covariates")


def known_arguments(encounter: Encounter, *, scalars: bool, one_frame: bool) -> list[Argument]:
    """Return all arguments that the encounters of a campaign have.

    Parameters
    ----------
    scalars
        Only speeds are known, as in a table of impacts.
    one_frame
        The orientations of each sphere are of one body frame throughout.
    """
    found: list[Argument] = [*SPEEDS]
    if not scalars:
        found += OF_SPINS
    if encounter.point is not None:
        found += OF_PLACES
    if encounter.rotation is not None and one_frame:
        found += ON_BODIES
    columns: Sequence[str] = sorted(encounter.covariates, key=_rank)
    return found + [column_argument(name, encounter.covariates[name]) for name in columns]
