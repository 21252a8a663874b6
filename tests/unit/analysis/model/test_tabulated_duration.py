"""Measured durations of tabulated contacts are data of the law of contacts that last.

The contacts are those of the simulators, which share no code with the model.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.effects.contact.lasting_contact import EFFECT
from analysis.errors import InputError
from analysis.model.data.gather import gather
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.robust_fit import RobustFit, robust_fit
from simulators.challenge.bodies import Bodies
from simulators.challenge.encounter import collide
from simulators.challenge.flight import acceleration
from simulators.challenge.force_choice import Forces
from simulators.challenge.launch import draw_settings, draw_touch
from simulators.challenge.nature import Nature
from simulators.world.description import Environment, Sphere
from tests.unit.analysis.model.exchange_folder import DESCRIPTION
from tests.unit.analysis.model.tabulated import (
    CONTACTS,
    PLATE,
    SIGMA_V,
    SIGMA_W,
    contacts,
    folder_with,
)

Floats = NDArray[np.float64]
DURATION, SIGMA = 2.4e-4, 2e-6
"""Of an undamped contact at 1 m/s, s, and the error of a measured one."""
COLUMNS = ["duration_s", "sigma_duration_s"]


@cache
def shots() -> tuple[Floats, Floats, Floats]:
    """Return normals, states before and after (40, 24), and how long contacts last, (40,)."""
    rng = np.random.default_rng(3)
    nature = Nature(forces=Forces(duration_s=DURATION))
    settings = draw_settings(40, rng)
    touch = draw_touch(settings, Sphere(), rng)
    weightless = replace(Environment(), gravity_m_per_s2=0.0, drag_coefficient=0.0)
    bodies = Bodies.of(Sphere(), nature)
    passage = collide(nature, settings, touch, acceleration(nature, bodies, weightless))
    apart = np.linalg.norm(passage.position[:, :, 1] - passage.position[:, :, 0], axis=2)
    overlap = Sphere().diameter_m - apart
    last = len(overlap) - 1 - np.argmax(overlap[::-1] > 0, axis=0)
    here, then = (np.take_along_axis(overlap, (last + k)[None], axis=0)[0] for k in (0, 1))
    steps = last + here / (here - then)
    lasts = passage.ends_s.ravel() * steps / (len(overlap) - 1)
    states = [touch.velocity, touch.spin, passage.velocity, passage.spin]
    return touch.normal, np.concatenate([s.reshape(40, 6) for s in states], axis=1), lasts


def folder(place: Path, sigma: float | None, *, only: int = 40, off: float = 0.0) -> Path:
    """Write contacts.csv, durations in the first `only` rows; None: no such columns."""
    rng = np.random.default_rng(4)
    normal, states, lasts = shots()
    scale = np.tile(np.repeat([SIGMA_V, SIGMA_W], 6), 2)
    rows: list[list[object]] = [[*CONTACTS, *(COLUMNS if sigma is not None else [])]]
    for s in range(len(states)):
        measured = states[s] + rng.normal(0, scale)
        row: list[object] = [s + 1, *map(float, normal[s]), *map(float, measured), SIGMA_V, SIGMA_W]
        if sigma is not None:
            known = [float(lasts[s] + off + rng.normal(0, sigma)), sigma]
            row += known if s < only else ["", ""]
        rows.append(row)
    return folder_with(place, "contacts.csv", rows, DESCRIPTION)


@cache
def table(sigma: float | None, only: int = 40, off: float = 0.0) -> ContactTable:
    with TemporaryDirectory() as made:
        data = gather(folder(Path(made), sigma, only=only, off=off))[1]
    assert isinstance(data, ContactTable)
    return data


@cache
def fitted(sigma: float | None, only: int = 40) -> RobustFit:
    return robust_fit(table(sigma, only), [EFFECT])


def test_durations_say_how_long_contacts_last_many_times_as_well_as_velocities() -> None:
    plain, timed = (fitted(s).fit.parameters()["lasting-contact.t"] for s in (None, SIGMA))
    assert abs(timed.value - DURATION) < 4 * timed.sigma
    assert timed.sigma < 0.25 * plain.sigma
    assert timed.sigma < 1.5 * SIGMA * 1.3 / np.sqrt(40)


def test_the_law_with_durations_reaches_the_noise() -> None:
    fit = fitted(SIGMA).fit
    assert fit.chi2_per_dof == pytest.approx(1.0, abs=4 * np.sqrt(2 / fit.freedom))
    found = fit.parameters()
    assert abs(found["e"].value - 0.74) < 4 * found["e"].sigma + 2e-4
    assert abs(found["mu"].value - 0.08) < 4 * found["mu"].sigma


def test_rows_without_a_duration_count_as_ever() -> None:
    some, every = fitted(SIGMA, 10).fit, fitted(SIGMA).fit
    assert some.residuals == every.residuals - 30
    few, all_ = (fit.parameters()["lasting-contact.t"] for fit in (some, every))
    assert few.sigma == pytest.approx(2 * all_.sigma, rel=0.3)


def test_hard_spheres_part_at_once_and_a_duration_contradicts_them() -> None:
    data = table(SIGMA)
    hard, lasting = robust_fit(data).fit, fitted(SIGMA).fit
    extra = float(((shots()[2] / SIGMA) ** 2).sum())
    assert hard.chi2 > 0.9 * extra
    assert lasting.chi2 < 0.01 * extra


def test_a_duration_without_its_error_is_refused(tmp_path: Path) -> None:
    place = folder(tmp_path, SIGMA)
    path = place / "contacts.csv"
    text = path.read_text().replace(f",{SIGMA}\n", ",\n", 1)
    path.write_text(text)
    with pytest.raises(InputError, match="state its standard error, or leave both empty"):
        gather(place)


def test_a_contact_does_not_end_before_it_begins(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="a contact ends after it begins"):
        gather(folder(tmp_path, SIGMA, off=-1e-3))


def test_errors_are_stated_of_durations_and_velocities_alike(tmp_path: Path) -> None:
    place = contacts(tmp_path, 30, 5, stated=False)
    path = place / "contacts.csv"
    head, *rows = path.read_text().splitlines()
    timed = [f"{row},1e-4,1e-6" for row in rows]
    path.write_text("\n".join([f"{head},{','.join(COLUMNS)}", *timed]) + "\n")
    with pytest.raises(InputError, match="state all of them"):
        gather(place)


def test_a_plate_is_left_where_the_sphere_leaves_it(tmp_path: Path) -> None:
    place = contacts(tmp_path, 12, 6)
    (place / "campaign.toml").write_text(PLATE, encoding="utf-8")
    path = place / "contacts.csv"
    head, *rows = path.read_text().splitlines()
    names = head.split(",")
    still = [n for n in names if n.startswith(("vb_", "wb_"))]
    out = []
    for row in rows:
        fields = dict(zip(names, row.split(","), strict=True))
        fields |= dict.fromkeys(still, "")
        out.append(",".join([*fields.values(), "1e-4", "1e-6"]))
    path.write_text("\n".join([f"{head},{','.join(COLUMNS)}", *out]) + "\n")
    data = gather(place)[1]
    hard = robust_fit(data).fit
    # Each contact is 100 of its errors too long for a hard plate.
    assert hard.chi2 > 12 * 90.0**2
