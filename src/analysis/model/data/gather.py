"""From a campaign folder, or from shots measured here, to the arrays that are fitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.campaign import DESCRIPTION, FRAMES, SHOT_LIST, analyse_campaign, read_campaign
from analysis.collision.operator import Body
from analysis.errors import InputError
from analysis.exchange.contact_table import read_contacts
from analysis.exchange.description import read_description
from analysis.exchange.impact_table import read_impacts
from analysis.exchange.pose_table import (
    PoseRow,
    measured_poses,
    own_slow_errors,
    read_poses,
    turn_matrix,
)
from analysis.exchange.shot_list import ShotRow, read_shot_list
from analysis.exchange.tabulated import Tabulated
from analysis.model.data.columns import ShotColumns
from analysis.model.data.inside import shows_both_sides
from analysis.model.data.plate import BOUNCES_A_SHOT, Plate, by_bounce
from analysis.model.data.plate_found import plate_of
from analysis.model.data.poses import PoseData
from analysis.model.data.tables import ContactTable, Data
from analysis.model.data.tables_build import contacts_table, impacts_table, with_scatter_as_noise
from analysis.model.predict.start import LEAST_FOR_A_LINE, LEAST_FRAMES
from analysis.scene import bodies_of
from analysis.setup import Setup, SlowErrors
from analysis.shot import AnalysisOptions, MeasuredShot
from analysis.shot_poses import shape_of
from analysis.slow_errors import typical

POSES, CONTACTS, IMPACTS = "poses.csv", "contacts.csv", "impacts.csv"
LEAST_OF_PAIRS, LEAST_APART = 2 * LEAST_FOR_A_LINE, 0.5
"""Frames of two spheres: a line before the contact and one after it. Centres nearer than this share
of what touching spheres have are those of one sphere, or of none."""
GUESSES = 2e-5, 8e-3
"""m and rad, for errors that nobody stated: what images of 40 px a sphere give."""

T = TypeVar("T", bound=Tabulated)
Shots = Mapping[int, Mapping[str, Sequence[PoseRow]]]


def gather(campaign: Path) -> tuple[str, Data]:
    """Read a campaign at the latest stage that is there, or at the one that is named.

    The latest is contacts.csv, else impacts.csv, else poses.csv, else the frames, measured now.

    Parameters
    ----------
    campaign
        The folder, or one of these files in it: that stage is taken, whatever else is there.

    Returns
    -------
    The campaign's name, and its contacts or its poses.

    Raises
    ------
    InputError
        A file cannot be read, a sphere a is a plate, a plate b stands where only frames are, no
        shot has contacts or poses, or the file that is named holds no stage.
    """
    folder, named = (campaign.parent, campaign.name) if campaign.is_file() else (campaign, None)
    if named not in {None, POSES, CONTACTS, IMPACTS}:
        raise InputError(campaign, f"is none of {CONTACTS}, {IMPACTS} and {POSES}")
    name, setup = read_description(folder / DESCRIPTION)
    rows = read_shot_list(folder / SHOT_LIST)
    if setup.spheres[0].plate:
        raise InputError(folder / DESCRIPTION, "spheres: a is a plate; only b can be one")
    stage = latest_table(folder) if named is None else named
    if stage == CONTACTS:
        return name, _contacts(folder / CONTACTS, rows, setup)
    if stage == IMPACTS:
        return name, _impacts(folder / IMPACTS, rows, setup)
    return name, gather_poses(folder)[1]


def latest_table(folder: Path) -> str | None:
    """Return the name of the table of the latest stage that a folder holds; None: it has none."""
    return next((file for file in (CONTACTS, IMPACTS, POSES) if (folder / file).exists()), None)


def gather_poses(folder: Path) -> tuple[str, PoseData]:
    """Read the poses of a campaign's folder, whatever later stage there is.

    From poses.csv where it is there, else from its frames, measured now.

    Raises
    ------
    InputError
        A file cannot be read, no shot has poses, or frames show a sphere on a plate.
    """
    name, setup = read_description(folder / DESCRIPTION)
    rows = read_shot_list(folder / SHOT_LIST)
    if (folder / POSES).exists():
        shots: Shots = read_poses(folder / POSES)
    elif setup.spheres[1].plate:
        reason = f"no {POSES}; have a film of a ball measured: rigctl analyse {folder} --out"
        raise InputError(folder, reason)
    elif not (folder / FRAMES).exists():
        raise InputError(folder, f"holds no poses: neither {POSES} nor {FRAMES} is there")
    else:
        shots, setup = _measured_now(folder, setup)
    counting = set(shots) - {row.shot for row in rows if row.is_excluded}
    data = usable(every_shot(shots, rows, setup)) if counting else None
    if data is None or len(data.shots) == 0:
        raise InputError(folder, nothing_seen(setup))
    return name, data


def nothing_seen(setup: Setup) -> str:
    """Return the sentence on a campaign of which no shot can be used."""
    if setup.spheres[1].plate:
        return (
            "no shot of this campaign shows sphere a coming near a plate and leaving it; where it "
            "does not lie below the sphere, state its normal: spheres, b, normal = [x, y, z]"
        )
    return (
        f"no shot of this campaign has {LEAST_FOR_A_LINE} frames or more that show both spheres "
        "apart before the contact, and as many after it; frames of the contact itself do not count"
    )


def _measured_now(folder: Path, setup: Setup) -> tuple[Shots, Setup]:
    """Measure frames; return poses by shot, and the set-up with how they err.

    What else was found of a shot is not kept.
    """
    poses: dict[int, dict[str, list[PoseRow]]] = {}
    errors: list[SlowErrors] = []
    for job, shot, _ in analyse_campaign(read_campaign(folder), AnalysisOptions()):
        if isinstance(shot, MeasuredShot):
            poses[job.shot] = measured_poses(shot)
            errors.append(shot.slow)
    return poses, typical(setup, errors)


def pose_data(shots: Shots, rows: Sequence[ShotRow], setup: Setup) -> PoseData:
    """Put poses into arrays as `every_shot`, without shots whose frames do not show both spheres.

    Where none does, all stay.
    """
    data = every_shot(shots, rows, setup)
    shown = usable(data)
    return shown if len(shown.shots) > 0 else data


def every_shot(shots: Shots, rows: Sequence[ShotRow], setup: Setup) -> PoseData:
    """Put poses into arrays, frames of both spheres side by side, shots padded to the longest.

    Shots that a person excluded are left out and named. Errors that are not stated are guessed.
    """
    columns = ShotColumns(rows)
    counting = [own for number, own in shots.items() if number not in columns.excluded]
    stated = stated_poses(shots, columns, setup, plate_of(setup, counting))
    errors = zip(stated_medians(stated), GUESSES, strict=True)
    return replace(
        with_guesses(stated, *(typical_error(medians, guess) for medians, guess in errors)),
        covariates=columns.covariates(fired(stated)),
        unused=columns.unused(fired(stated)),
        camera=replace(setup.camera, exposure_s=columns.exposure_s(fired(stated))),
    )


def fired(data: PoseData) -> NDArray[np.intp]:
    """Return which shot of the shot list each is: a bounce on a plate is one of its shot's."""
    return data.shots // BOUNCES_A_SHOT if data.on_plate else data.shots


def stated_poses(shots: Shots, columns: ShotColumns, setup: Setup, plate: Plate) -> PoseData:
    """Put poses into arrays as they were stated: an error that is not stated is NaN.

    What all shots share of the shot list is still to come.

    Parameters
    ----------
    plate
        How it lies, where b is one.
    """
    excluded = columns.excluded & set(shots)
    if setup.spheres[1].plate:
        counting = {n: own for n, own in shots.items() if n not in excluded}
        shots = by_bounce(counting, plate, setup.environment.gravity_m_per_s2)
    numbers = sorted(set(shots) - excluded if not setup.spheres[1].plate else shots)
    frames = {s: sorted({r.frame for rows_ in shots[s].values() for r in rows_}) for s in numbers}
    longest = max(1, *(len(own) for own in frames.values()))
    shape = (len(numbers), longest)
    times = np.zeros(shape)
    position, position_sigma = np.zeros((*shape, 2, 3)), np.full((*shape, 2, 3), np.inf)
    quaternions, turn_sigma = np.zeros((*shape, 2, 4)), np.full((*shape, 2), np.inf)
    quaternions[..., 0] = 1.0
    turn_shape = None
    for s, number in enumerate(numbers):
        place = {frame: k for k, frame in enumerate(frames[number])}
        for i, name in enumerate("ab"):
            for row in shots[number].get(name, ()):
                k = place[row.frame]
                times[s, k] = row.t_s
                position[s, k, i] = row.position
                position_sigma[s, k, i] = row.position_sigma
                if row.quaternion is not None:
                    quaternions[s, k, i] = row.quaternion
                    turn_sigma[s, k, i] = row.rotation_sigma
                if row.turn_covariance is not None:
                    if turn_shape is None:
                        turn_shape = np.tile(np.eye(3), (*shape, 2, 1, 1))
                    turn_shape[s, k, i] = shape_of(turn_matrix(row.turn_covariance))
        times[s, len(place) :] = times[s, len(place) - 1] if place else 0.0
    return PoseData(
        shots=np.array(numbers, dtype=np.intp),
        times_s=times,
        position=np.nan_to_num(position),
        position_sigma=position_sigma,
        rotation=_matrices(quaternions),
        rotation_sigma=turn_sigma,
        turn_shape=turn_shape,
        slow=setup.measurement,
        own_slow={number: own_slow_errors(shots[number], setup.measurement) for number in numbers},
        bodies=bodies_of(setup),
        gravity=setup.environment.gravity_m_per_s2,
        air_density=setup.environment.air_density_kg_per_m3,
        drag_coefficient=setup.environment.drag_coefficient,
        drag_sigma=setup.environment.drag_coefficient_sigma,
        length_sigma=setup.stated_length_sigma,
        covariates={},
        camera=setup.camera,
        excluded=tuple(sorted(excluded)),
        plate=plate,
    )


def _contacts(path: Path, rows: Sequence[ShotRow], setup: Setup) -> ContactTable:
    found = read_contacts(path, plate=setup.spheres[1].plate)
    table = contacts_table(*_of_shots(path, found, rows, setup))
    return _table(path, table, _left_out(found, rows))


def _impacts(path: Path, rows: Sequence[ShotRow], setup: Setup) -> ContactTable:
    found = read_impacts(path)
    table = impacts_table(*_of_shots(path, found, rows, setup))
    return _table(path, table, _left_out(found, rows))


def _left_out(found: Sequence[Tabulated], rows: Sequence[ShotRow]) -> tuple[int, ...]:
    """Return the numbers of the tabulated shots that a person excluded."""
    excluded = {row.shot for row in rows if row.is_excluded}
    return tuple(row.shot for row in found if row.shot in excluded)


def _of_shots(
    path: Path, found: Sequence[T], rows: Sequence[ShotRow], setup: Setup
) -> tuple[Sequence[T], tuple[Body, Body], dict[str, Floats], float]:
    """Return tabulated rows that count with what the other files say of them."""
    excluded = _left_out(found, rows)
    found = [row for row in found if row.shot not in excluded]
    if not found:
        raise InputError(path, "holds no shots that count")
    bodies = bodies_of(setup)
    numbers = np.array([row.shot for row in found], dtype=np.intp)
    covariates = ShotColumns(rows).covariates(numbers)
    return found, bodies, covariates, setup.environment.gravity_m_per_s2


def _table(path: Path, table: ContactTable, excluded: tuple[int, ...]) -> ContactTable:
    table = replace(table, excluded=excluded)
    try:
        return with_scatter_as_noise(table) if table.estimated else table
    except ValueError as error:
        raise InputError(path, f"no errors are stated, and {error}; state them") from error


def usable(data: PoseData) -> PoseData:
    """Leave out shots without frames that show both spheres apart; their numbers are kept.

    On either side of the contact enough for a line, where two spheres meet.
    """
    seen, least = data.seen, LEAST_FRAMES
    if not data.on_plate:
        least = LEAST_OF_PAIRS
        apart = np.linalg.norm(data.position[:, :, 1] - data.position[:, :, 0], axis=2)
        reach = data.bodies[0].radius + data.bodies[1].radius
        seen = seen & ~(apart < LEAST_APART * reach)
    shown = seen.sum(axis=1) >= least
    if not data.on_plate and shown.any():
        shown[shown] = shows_both_sides(data.of_shots(shown))
    return replace(data.of_shots(shown), unusable=tuple(int(n) for n in data.shots[~shown]))


def stated_medians(data: PoseData) -> tuple[Floats, Floats]:
    """Return the median stated error of positions and orientations, of the shots that state any."""
    return _medians(data.position_sigma), _medians(data.rotation_sigma)


def _medians(sigma: Floats) -> Floats:
    stated = [own[np.isfinite(own)] for own in sigma]
    return np.array([np.median(own) for own in stated if own.size])


def typical_error(medians: Floats, guess: float) -> float:
    """Return what stands for errors that nobody stated: the median of the shots' medians.

    Only a start, as the scatter about free flight is what counts in the end.
    """
    return float(np.median(medians)) if medians.size else guess


def with_guesses(data: PoseData, position: float, rotation: float) -> PoseData:
    """Put guesses for errors that are not stated (NaN), m and rad."""
    missing = np.isnan(data.position_sigma), np.isnan(data.rotation_sigma)
    return replace(
        data,
        position_sigma=np.where(missing[0], position, data.position_sigma),
        rotation_sigma=np.where(missing[1], rotation, data.rotation_sigma),
        estimated=bool(missing[0].any() or missing[1].any()),
    )


def _matrices(quaternions: Floats) -> Floats:
    """Return rotation matrices of unit quaternions, scalar first, (..., 4) to (..., 3, 3)."""
    w, x, y, z = np.moveaxis(quaternions, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
