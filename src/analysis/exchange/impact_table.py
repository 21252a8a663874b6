"""Reading impacts.csv: the scalars of an impact, as published tables give them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from analysis.exchange.rows import TableRow, read_rows
from analysis.exchange.tabulated import Tabulated, require_errors_alike, require_once

QUANTITIES = ("v_n", "v_s", "v_n_after", "v_s_after")
SIGMAS = tuple(f"sigma_{name}" for name in QUANTITIES)


@dataclass(frozen=True, slots=True)
class ImpactRow(Tabulated):
    """One impact, in the order of `QUANTITIES`.

    Attributes
    ----------
    speeds
        m/s (thesis, section 7.1): v_n negative, v_s a length; NaN where not measured.
    sigmas
        Standard errors, m/s; None: not stated.
    """

    speeds: tuple[float, ...]
    sigmas: tuple[float | None, ...]


def read_impacts(path: Path) -> list[ImpactRow]:
    """Read impacts.csv, shots in the order of their numbers.

    Raises
    ------
    InputError
        A column missing or unknown, a field that is no number, v_n that is not there or not
        negative, v_s or v_n_after that is negative, a sigma that is not positive or stated for some
        numbers only, a shot that stands twice; with the line.
    """
    rows = read_rows(path, ("shot", *QUANTITIES), SIGMAS)
    found = [_impact(row) for row in rows]
    require_once(rows, found)
    require_errors_alike(rows, [_without_error(impact) for impact in found])
    return sorted(found, key=lambda impact: impact.shot)


def _impact(row: TableRow) -> ImpactRow:
    speeds = {name: row.number(name) for name in QUANTITIES}
    if speeds["v_n"] is None:
        raise row.fault("v_n: empty; the normal velocity before contact must be there")
    if speeds["v_n"] >= 0:
        raise row.fault(f"v_n: {speeds['v_n']} is not negative, as it is before contact")
    for name in ("v_s", "v_n_after"):
        if (value := speeds[name]) is not None and value < 0:
            raise row.fault(f"{name}: {value} is negative; it is 0 at least")
    return ImpactRow(
        shot=row.whole("shot"),
        speeds=tuple(math.nan if v is None else v for v in speeds.values()),
        sigmas=tuple(map(row.sigma, SIGMAS)),
    )


def _without_error(impact: ImpactRow) -> tuple[str, ...]:
    """Return the sigmas that are needed and not stated."""
    rows = zip(SIGMAS, impact.speeds, impact.sigmas, strict=True)
    return tuple(name for name, speed, s in rows if not math.isnan(speed) and s is None)
