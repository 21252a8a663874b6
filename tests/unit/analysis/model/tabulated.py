"""Folders with tables of contacts, written from the description of their format alone.

The collisions are those of hard_spheres and of Walton's two lines in scalars.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.unit.analysis.model.exchange_folder import DESCRIPTION
from tests.unit.analysis.model.hard_spheres import Drawn, collided, draw

Floats = NDArray[np.float64]

SIGMA_V, SIGMA_W = 0.004, 0.4
AXES = "xyz"
STATE = [f"{kind}{sphere}_{axis}" for kind in "vw" for sphere in "ab" for axis in AXES]
CONTACTS = [
    *("shot", "nx", "ny", "nz"),
    *STATE,
    *(f"{name}_after" for name in STATE),
    *("sigma_v_m_per_s", "sigma_w_rad_per_s"),
]
IMPACTS = ["shot", "v_n", "v_s", "v_n_after", "v_s_after"]
PLATE = DESCRIPTION.replace(
    'name = "b"\ndiameter_m = 0.0254\ndensity_kg_per_m3 = 1150.0', 'name = "b"\nplate = true'
)


def folder_with(folder: Path, file: str, rows: list[list[object]], description: str) -> Path:
    """Write campaign.toml, shots.csv and one table whose first row names the columns."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "campaign.toml").write_text(description, encoding="utf-8")
    shots = ["shot", *(str(row[0]) for row in rows[1:])]
    (folder / "shots.csv").write_text("\n".join(shots) + "\n", encoding="utf-8")
    lines = [",".join(map(str, row)) for row in rows]
    (folder / file).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder


def contacts(
    folder: Path,
    shots: int,
    seed: int,
    law: tuple[float, float, float] = (0.74, 0.08, 0.5),
    *,
    slope: float = 0.0,
    stated: bool = True,
    noise: float = 1.0,
) -> Path:
    """Write contacts.csv of `shots` collisions of two spheres, with Gaussian noise."""
    rng = np.random.default_rng(seed)
    drawn = draw(rng, shots)
    return write_contacts(folder, drawn, rng, law, slope=slope, stated=stated, noise=noise)


def write_contacts(
    folder: Path,
    drawn: Drawn,
    rng: np.random.Generator,
    law: tuple[float, float, float],
    *,
    slope: float = 0.0,
    stated: bool = True,
    noise: float = 1.0,
) -> Path:
    velocity, spin = collided(drawn.velocity, drawn.spin, drawn.normal, law, slope)
    rows: list[list[object]] = [list(CONTACTS)]
    sigmas: list[object] = [SIGMA_V, SIGMA_W] if stated else ["", ""]
    for s, normal in enumerate(drawn.normal):
        state = np.concatenate(
            [drawn.velocity[s].ravel(), drawn.spin[s].ravel(), velocity[s].ravel(), spin[s].ravel()]
        )
        scale = np.tile(np.repeat([SIGMA_V, SIGMA_W], 6), 2)
        measured = state + noise * rng.normal(0, scale)
        rows.append([s + 1, *map(float, normal), *map(float, measured), *sigmas])
    return folder_with(folder, "contacts.csv", rows, DESCRIPTION)


def walton(
    v_n: float, v_s: float, law: tuple[float, float, float], slope: float = 0.0
) -> tuple[float, float]:
    """Return v_n' and v_s' of solid spheres from speeds taken positive, in scalars."""
    e0, mu, beta0 = law
    e = e0 * (1 - slope * (v_n**0.2 - 2**0.2) / 0.2)
    return e * v_n, max(-beta0 * v_s, v_s - 3.5 * mu * (1 + e) * v_n)


def impacts(
    folder: Path,
    shots: int,
    seed: int,
    law: tuple[float, float, float] = (0.74, 0.08, 0.5),
    *,
    slope: float = 0.0,
    friction_slope: float = 0.0,
    sigma: float | None = 0.01,
    noise: float = 0.01,
    description: str = DESCRIPTION,
    setting: tuple[float, float] | None = None,
) -> Path:
    """Write impacts.csv: half of the shots stick, half slide; or all are at one setting.

    `sigma` None leaves the errors out; `noise` is what the numbers really scatter by, m/s.
    """
    rng = np.random.default_rng(seed)
    names = [f"sigma_{name}" for name in IMPACTS[1:]] if sigma is not None else []
    rows: list[list[object]] = [[*IMPACTS, *names]]
    for s in range(shots):
        v_n = rng.uniform(0.5, 5.0)
        v_s = v_n * (rng.uniform(0.05, 0.28) if s % 2 else rng.uniform(0.4, 3.0))
        if setting is not None:
            v_n, v_s = setting
        e, mu, beta0 = law
        slid = (e, mu * (1 + friction_slope * float(np.log(v_s))), beta0)
        after = walton(v_n, v_s, slid, slope)
        measured = np.array([-v_n, v_s, *after]) + rng.normal(0, noise, 4)
        measured[1] = abs(measured[1])
        rows.append([s + 1, *map(float, measured), *([sigma] * len(names))])
    return folder_with(folder, "impacts.csv", rows, description)
