"""A campaign as a NeXus file: poses, coefficients and where they came from, in HDF5.

NeXus (M. Koennecke et al., J. Appl. Cryst. 48, 301 (2015)) names groups by class and gives every
number its unit; `x_errors` holds the standard errors of `x`. Axes are those of the rig: X down, Y
right, Z toward the camera. No application definition covers collisions, so none is claimed.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from analysis.collision.operator import Body
from analysis.model.data.poses import PoseData
from analysis.quantity import Quantity
from analysis.results.campaign import Results
from analysis.results.impacts import V_N
from analysis.results.ratios import Ratio
from rigctl.errors import StoreError
from rigctl.reports.source import Facts, Source
from rigctl.units import RATIO, unit_of

AXES = "X down, Y right, Z toward the camera"


def write_nexus(path: Path, source: Source, found: Results) -> None:
    """Write a campaign with its results.

    The file appears whole or not at all; one that is there already is not replaced.

    Raises
    ------
    StoreError
        The file is there, or cannot be written.
    """
    if path.exists():
        raise StoreError("is there already", part=str(path), todo="choose another name")
    partial = path.with_name(f".{path.name}.partial")
    try:
        with h5py.File(partial, "w") as file:
            _root(file, source, found)
        os.replace(partial, path)
    except OSError as error:
        raise StoreError(
            f"cannot be written: {error.strerror or error}",
            part=str(path),
            todo="free the disk, or choose another place",
        ) from error
    finally:
        with suppress(OSError):
            partial.unlink()


def _root(file: h5py.File, source: Source, found: Results) -> None:
    file.attrs["NX_class"] = "NXroot"
    file.attrs["default"] = "entry"
    file.attrs["creator"] = "rigctl"
    entry = _group(file, "entry", "NXentry")
    entry.attrs["default"] = "coefficients"
    entry["title"] = source.title
    entry["program_name"] = "rigctl"
    entry["program_name"].attrs["version"] = version("rigctl")
    if source.simulated is not None:
        entry["simulated"] = source.simulated
    if isinstance(source.data, PoseData):
        _poses(_group(entry, "poses", "NXcollection"), source.data)
    _bodies(_group(entry, "sample", "NXsample"), source.data.bodies)
    _settings(_group(entry, "settings", "NXcollection"), source)
    _coefficients(_group(entry, "coefficients", "NXdata"), found)
    _parameters(_group(entry, "regression", "NXprocess"), found.coefficients())
    _parameters(_group(entry, "whole_fit", "NXprocess"), found.whole_fit)
    _left_out(_group(entry, "left_out", "NXcollection"), source, found)
    _described(_group(entry, "instrument", "NXinstrument"), source.facts)
    _files(_group(entry, "files", "NXcollection"), source)


def _group(parent: h5py.Group, name: str, kind: str) -> h5py.Group:
    group = parent.create_group(name)
    group.attrs["NX_class"] = kind
    return group


def _number(group: h5py.Group, name: str, values: object, unit: str) -> None:
    group[name] = values
    group[name].attrs["units"] = unit


def _poses(group: h5py.Group, data: PoseData) -> None:
    group.attrs["axes"] = AXES
    group.attrs["dimensions"] = "shot, frame, sphere (a, b), axis"
    group.attrs["not_measured"] = "infinite errors"
    _number(group, "shot", data.shots, RATIO)
    _number(group, "time", data.times_s, "s")
    _number(group, "position", data.position, "m")
    _number(group, "position_errors", data.position_sigma, "m")
    _number(group, "orientation", data.rotation, RATIO)
    group["orientation"].attrs["meaning"] = "rotation matrices, body to rig axes"
    _number(group, "orientation_errors", data.rotation_sigma, "rad")
    _number(group, "slow_position_errors", data.slow.position_m, "m")
    _number(group, "slow_orientation_errors", data.slow.rotation_rad, "rad")
    _number(group, "scale_error", data.slow.scale, RATIO)
    group["one_body_frame"] = data.slow.one_body_frame
    _number(group, "gravity", data.gravity, "m/s^2")
    _number(group, "air_density", data.air_density, "kg/m^3")
    if data.drag_coefficient is not None:
        _number(group, "drag_coefficient", data.drag_coefficient, RATIO)
        _number(group, "drag_coefficient_error", data.drag_sigma, RATIO)


def _bodies(group: h5py.Group, bodies: tuple[Body, Body]) -> None:
    for name, body in zip("ab", bodies, strict=True):
        part = _group(group, f"sphere_{name}", "NXcollection")
        part["plate"] = body.is_plate
        if not body.is_plate:
            _number(part, "mass", body.mass, "kg")
            _number(part, "radius", body.radius, "m")
            _number(part, "inertia", body.inertia, "kg m^2")


def _settings(group: h5py.Group, source: Source) -> None:
    """Write the covariates of each shot; the unit is the ending of the column's name."""
    _number(group, "shot", source.data.shots, RATIO)
    for name, values in sorted(source.data.covariates.items()):
        _number(group, name, values, unit_of(name))


def _coefficients(group: h5py.Group, found: Results) -> None:
    impacts, each = found.impacts, found.ratios
    group.attrs["signal"] = "e"
    group.attrs["axes"] = ["approach_speed"]
    group.attrs["auxiliary_signals"] = ["beta", "f"]
    _number(group, "shot", impacts.shots, RATIO)
    _number(group, "approach_speed", impacts.approach, "m/s")
    variance = impacts.covariance[:, V_N, V_N]
    _number(group, "approach_speed_errors", np.sqrt(variance), "m/s")
    ratios: Mapping[str, Ratio] = {
        "e": each.e,
        "beta": each.beta,
        "f": each.f,
        "incidence": each.incidence,
        "rebound": each.rebound,
    }
    for name, ratio in ratios.items():
        _number(group, name, ratio.value, RATIO)
        _number(group, f"{name}_errors", ratio.sigma, RATIO)
        _number(group, f"{name}_errors_own", ratio.own, RATIO)
        _number(group, f"{name}_errors_common", ratio.common, RATIO)
    _number(group, "probability_of_sliding", found.lines.held.slides, RATIO)
    _number(group, "velocities", impacts.velocities, "m/s")
    group["velocities"].attrs["columns"] = ["v_n", "v_s", "v_n_after", "v_s_after"]
    _number(group, "velocities_covariance", impacts.covariance, "m^2/s^2")


def _parameters(group: h5py.Group, parameters: Mapping[str, Quantity]) -> None:
    group["program"] = "rigctl"
    group["version"] = version("rigctl")
    for parameter, quantity in parameters.items():
        # NeXus names hold letters, digits and underscores.
        name = parameter.replace("-", "_").replace(".", "_")
        _number(group, name, quantity.value, quantity.unit)
        _number(group, f"{name}_errors", quantity.sigma, quantity.unit)


def _left_out(group: h5py.Group, source: Source, found: Results) -> None:
    left_out = sorted([*source.missing, *found.left_out, *found.far], key=lambda one: one.shot)
    _number(group, "shot", np.array([one.shot for one in left_out], dtype=np.int64), RATIO)
    group["reason"] = _texts([one.reason for one in left_out])


def _described(group: h5py.Group, facts: tuple[Facts, ...]) -> None:
    """Write the apparatus as it was described, as text; names end in their units."""
    for part in facts:
        below = _group(group, part.heading.replace(" ", "_"), "NXcollection")
        for name, value in part.rows:
            below[name.replace("/", " ")] = value


def _files(group: h5py.Group, source: Source) -> None:
    group["name"] = _texts([name for name, _ in source.files])
    group["sha256"] = _texts([digest for _, digest in source.files])


def _texts(texts: list[str]) -> NDArray[np.object_]:
    return np.array(texts, dtype=h5py.string_dtype())
