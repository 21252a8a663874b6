"""contacts.csv, read and written: states of both spheres just before and just after contact."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis.arrays import Floats
from analysis.collision.impact import ContactState
from analysis.exchange.rows import TableRow, WriteShot, read_rows, table_writer
from analysis.exchange.tabulated import Tabulated, require_errors_alike, require_once
from analysis.shot import MeasuredShot

NORMAL = ("nx", "ny", "nz")
SIGMAS = ("sigma_v_m_per_s", "sigma_w_rad_per_s")
_STATE = [f"{kind}{sphere}_{axis}" for kind in "vw" for sphere in "ab" for axis in "xyz"]
CONTACT_SIGMAS = [f"sigma_{name}{suffix}" for suffix in ("", "_after") for name in _STATE]
"""May stand in contacts.csv: standard errors of single numbers, m/s and rad/s."""
DURATION = ["duration_s", "sigma_duration_s"]
"""May stand in contacts.csv: how long a contact lasts, where that was measured, s."""
CONTACTS = ["shot", *NORMAL, *_STATE, *(f"{name}_after" for name in _STATE), *SIGMAS]
VELOCITIES, SPINS = ("va", "vb"), ("wa", "wb")
AXES = "xyz"
_UNIT_TOLERANCE = 1e-3


@dataclass(frozen=True, slots=True)
class ContactRow(Tabulated):
    """One contact; numbers that were not measured are NaN.

    Attributes
    ----------
    normal
        Unit vector from a to b.
    before, after
        Velocities of a and b, m/s, then spins of a and b, rad/s, in rig axes: 12 numbers each.
    sigma_v, sigma_w
        Standard errors of velocities and spins, m/s and rad/s; None: not stated.
    sigmas
        Standard errors of the 24 numbers before and after, where stated one by one; else None, and
        the error of each kind applies.
    duration_s, sigma_duration_s
        How long the contact lasts, from touch to parting, and its standard error, s; None: not
        measured.
    """

    normal: tuple[float, float, float]
    before: tuple[float, ...]
    after: tuple[float, ...]
    sigma_v: float | None
    sigma_w: float | None
    sigmas: tuple[float | None, ...] = (None,) * 24
    duration_s: float | None = None
    sigma_duration_s: float | None = None

    @property
    def errors(self) -> tuple[float | None, ...]:
        """Standard errors of the 24 numbers, before and after."""
        kinds = (*(self.sigma_v,) * 6, *(self.sigma_w,) * 6) * 2
        return tuple(
            kind if own is None else own for own, kind in zip(self.sigmas, kinds, strict=True)
        )


def read_contacts(path: Path, *, plate: bool) -> list[ContactRow]:
    """Read contacts.csv, shots in the order of their numbers.

    Parameters
    ----------
    plate
        Whether b is a plate at rest: its fields are empty or 0.

    Raises
    ------
    InputError
        A column missing or unknown, a field that is no number, a normal that is not of length 1, a
        velocity before contact that is not there, bodies that do not approach each other, a plate
        that moves, a sigma that is not positive or stated in some lines only, a duration that is
        negative or without a standard error, a shot that stands twice; with the line.
    """
    needed = [name for name in CONTACTS if name not in SIGMAS]
    rows = read_rows(path, needed, (*SIGMAS, *CONTACT_SIGMAS, *DURATION))
    found = [_contact(row, plate=plate) for row in rows]
    require_once(rows, found)
    require_errors_alike(rows, [_without_error(contact, plate=plate) for contact in found])
    return sorted(found, key=lambda contact: contact.shot)


def _contact(row: TableRow, *, plate: bool) -> ContactRow:
    normal, before, after = _normal(row), _state(row, ""), _state(row, "_after")
    if plate:
        for suffix in ("", "_after"):
            _require_rest(row, suffix)
        before, after = _at_rest(before), _at_rest(after)
    for name, value in zip((f"v{s}_{x}" for s in "ab" for x in AXES), before[:6], strict=True):
        if math.isnan(value):
            raise row.fault(f"{name}: empty; every velocity before contact must be there")
    relative = (b - a for a, b in zip(before[:3], before[3:6], strict=True))
    approach = -sum(v * n for v, n in zip(relative, normal, strict=True))
    if approach <= 0:
        raise row.fault(
            f"the bodies part at {-approach:.4g} m/s before contact, along the normal from a to b"
        )
    sigma_v, sigma_w = map(row.sigma, SIGMAS)
    own = tuple(map(row.sigma, CONTACT_SIGMAS))
    number = row.whole("shot")
    return ContactRow(number, normal, before, after, sigma_v, sigma_w, own, *_duration(row))


def _duration(row: TableRow) -> tuple[float | None, float | None]:
    """Return a measured duration and its standard error, s."""
    value, sigma = row.number(DURATION[0]), row.sigma(DURATION[1])
    if value is None:
        return None, None
    if value < 0.0:
        raise row.fault(f"{DURATION[0]}: {value:g} s; a contact ends after it begins")
    if sigma is None:
        raise row.fault(
            f"{DURATION[1]}: empty beside a duration of {value:g} s; state its standard error, or "
            "leave both empty"
        )
    return value, sigma


def _normal(row: TableRow) -> tuple[float, float, float]:
    x, y, z = (row.number(name) for name in NORMAL)
    if x is None or y is None or z is None:
        raise row.fault("nx..nz: empty; the normal must be there")
    length = math.sqrt(x * x + y * y + z * z)
    if abs(length - 1.0) > _UNIT_TOLERANCE:
        raise row.fault(f"nx..nz: a normal of length {length:.4g}, not 1")
    return x / length, y / length, z / length


def _state(row: TableRow, suffix: str) -> tuple[float, ...]:
    fields = (row.number(f"{k}_{x}{suffix}") for k in (*VELOCITIES, *SPINS) for x in AXES)
    return tuple(math.nan if field is None else field for field in fields)


def _require_rest(row: TableRow, suffix: str) -> None:
    for name in (f"{kind}_{x}{suffix}" for kind in ("vb", "wb") for x in AXES):
        if row.number(name):
            raise row.fault(f"{name}: {row.fields[name]} for a plate, which is at rest")


def _at_rest(state: Sequence[float]) -> tuple[float, ...]:
    """Return a state whose b does not move."""
    return (*state[:3], 0.0, 0.0, 0.0, *state[6:9], 0.0, 0.0, 0.0)


def _without_error(contact: ContactRow, *, plate: bool) -> tuple[str, ...]:
    """Return the sigmas that are needed and not stated."""
    moving = [not plate or k % 6 < 3 for k in range(24)]
    numbers = (*contact.before, *contact.after)
    missing = [
        k
        for k, (value, sigma) in enumerate(zip(numbers, contact.errors, strict=True))
        if moving[k] and sigma is None and not math.isnan(value)
    ]
    return tuple(dict.fromkeys(SIGMAS[k % 12 >= 6] for k in missing))


@contextmanager
def contact_writer(path: Path) -> Iterator[WriteShot]:
    """Give a function that adds a shot to contacts.csv: one row for each.

    Beside the sigma of each number stand the root mean squares over axes and spheres. What was not
    measured stays empty.
    """
    with table_writer(path, [*CONTACTS, *CONTACT_SIGMAS]) as table:
        yield lambda number, shot: table.writerow(_fields(contact_row(number, shot)))


def contact_row(number: int, shot: MeasuredShot) -> ContactRow:
    """Return the contact of a measured shot, with the error of each number."""
    impact = shot.impact
    x, y, z = map(float, impact.normal)
    return ContactRow(
        number,
        (x, y, z),
        _numbers(impact.before),
        _numbers(impact.after),
        _mean(impact.state_sigma[:, 0:2]),
        _mean(impact.state_sigma[:, 2:4]),
        tuple(_known(sigma) for sigma in impact.state_sigma.ravel()),
    )


def _fields(row: ContactRow) -> list[object]:
    numbers = (_known(value) for value in (*row.before, *row.after))
    values = (*row.normal, *numbers, row.sigma_v, row.sigma_w, *row.sigmas)
    return [row.shot, *("" if value is None else value for value in values)]


def _mean(sigmas: Floats) -> float | None:
    """Return the root mean square of those that are known, None where none is."""
    known = sigmas[np.isfinite(sigmas)]
    return float(np.sqrt((known**2).mean())) if known.size else None


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _numbers(state: ContactState) -> tuple[float, ...]:
    parts = (state.velocity_a, state.velocity_b, state.spin_a, state.spin_b)
    return tuple(float(value) for part in parts for value in part)
