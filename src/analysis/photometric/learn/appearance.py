"""What is learned of a pair of spheres and their camera for every shot, and its file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from pathlib import Path
from typing import IO, Any
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.errors import InputError
from analysis.files import file_limits
from analysis.imaging.views import View
from analysis.photometric.learn.relief import FULL_TO
from analysis.photometric.render.camera import Camera, Optics
from analysis.photometric.render.shading import blurred_profiles, template
from analysis.photometric.render.sight import Look
from analysis.photometric.render.surface import draw

KEPT_LOOKS = 8
SHARED_PX = 0.002
"""What light and learned look leave in all flights of a campaign alike, about this much."""
LONE_SHARED_PX = 0.006
"""The same where one film taught: between the spheres 3 um in X and 7 um in Z, rms of six shots of
the simulated rig, where six films leave 1.4 um (decision 0035). It falls faster than the root of
their number."""
PRIOR_SLOW_PX = 0.0016
"""Of outlines in one flight, before any scatter is known: renderers that share nothing leave 0.001
and 0.003 (docs/decisions/0035-slow-errors-by-campaign.md)."""
FINE_BLUR = 0.0425
"""Blur over radius of the spheres for which the sizes above were found: 0.85 px of 20 px."""
NARROWEST_PX = 0.35
"""Standard deviation of a blur at least: a pixel's own is 0.29."""


@dataclass(frozen=True, slots=True, eq=False)
class Sphere:
    """How one sphere looks.

    Attributes
    ----------
    radius_m
        Of the sphere.
    markers
        Directions in body axes, unit vectors, shape (markers, 3).
    alpha
        Angular radius of the markers, radians.
    darkness
        Share of the light that a marker swallows, 0 to 1.
    shading
        Coefficients in each view in the order of `shading.HARMONICS`, shape (V, harmonics).
    reliefs
        What they leave inside the disc, on a square grid from -1 to 1, shape (V, n, n).
    """

    radius_m: float
    markers: Floats
    alpha: float
    darkness: float
    shading: Floats
    reliefs: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Appearance:
    """A camera and two spheres as images have shown them.

    Attributes
    ----------
    camera
        Views with their measured scales and origins.
    sigma_px
        Standard deviation of the blur in each view, lens and pixel together, shape (V,).
    spheres
        a and b.
    scale_sigma
        Relative standard error of the scale.
    camera_sigma
        Errors of `shared.Shared.camera` by the noise alone; infinite where undetermined.
    limb_px
        Radius by the outline less radius by the markers: light at the limb beyond the shading
        model. It shifts an outline by as much. 0 where markers do not determine the radius.
    pattern_sigma_rad
        Standard error of a marker's direction by the noise of the films that taught: the median of
        each sphere's, the larger one. Infinite where nothing has been learned.
    films
        How many films taught all of this together.
    slow_px
        Slow error of an outline's place in one flight (`slow_size.slow_size_px`).
    shared_px
        The same of what all flights measured with it share (`slow_size.shared_size_px`).
    smear_px2
        Variance that motion during the exposure added to the blur of the frames that taught, as
        far as it is round (`smear.round_variance`), shape (V,).
    """

    camera: Camera
    sigma_px: Floats
    spheres: tuple[Sphere, Sphere]
    scale_sigma: float
    camera_sigma: tuple[float, ...]
    limb_px: float
    pattern_sigma_rad: float
    films: int
    slow_px: float
    shared_px: float
    smear_px2: Floats

    @property
    def coarseness(self) -> float:
        """Factor on the scale's error by markers, against spheres of 20 px radius, at least 1.

        The model lays markers over shading that the blur has already spread, to first order: what
        is left grows with the square of the blur over the radius. Errors of places are multiplied
        by the mean of this and 1 (docs/decisions/0059-spheres-of-few-pixels.md).
        """
        scale = float(self.camera.optics.scales[0])
        radius_px = scale * min(sphere.radius_m for sphere in self.spheres)
        return max(1.0, (float(self.sigma_px.max()) / radius_px / FINE_BLUR) ** 2)

    @property
    def relief_share(self) -> float:
        """What smooth shading leaves inside the discs, as a share of their brightness (rms).

        Below 0.01 in light from the front, 0.1 to 0.3 under lamps with shadow or gloss.
        """
        shares = [
            relief[_inside(len(relief))] / shading[0]
            for sphere in self.spheres
            for relief, shading in zip(sphere.reliefs, sphere.shading, strict=True)
        ]
        return float(np.sqrt(np.mean(np.square(shares))))

    def smeared(self) -> Appearance:
        """Return the pair as a round blur shows it, the mean smear in it."""
        return _smeared(self) if self.smear_px2.any() else self

    def sharpened(self, smear_px2: Floats) -> Appearance:
        """Return the pair without the mean smear that a round blur has taken in."""
        sharp = np.maximum(self.sigma_px**2 - smear_px2, NARROWEST_PX**2)
        return replace(self, sigma_px=np.sqrt(sharp), smear_px2=self.sigma_px**2 - sharp)

    def looks(self, wider_px: float = 0.0) -> tuple[Look, Look]:
        """Return both spheres in the form of the fit, the blur wider by some pixels."""
        scales = tuple(self.camera.optics.scales.tolist())
        return _looks(self.spheres, tuple(self.sigma_px.tolist()), scales, wider_px)


def _inside(nodes: int) -> NDArray[np.bool_]:
    """Return which nodes of a square grid from -1 to 1 lie where a relief holds in full."""
    at = np.linspace(-1.0, 1.0, nodes)
    return np.hypot(at[:, None], at) < FULL_TO


@lru_cache(maxsize=KEPT_LOOKS)
def _smeared(known: Appearance) -> Appearance:
    wide = np.sqrt(known.sigma_px**2 + known.smear_px2)
    return replace(known, sigma_px=wide, smear_px2=np.zeros_like(wide))


@lru_cache(maxsize=KEPT_LOOKS)
def _looks(
    spheres: tuple[Sphere, Sphere],
    sigma_px: tuple[float, ...],
    scales: tuple[float, ...],
    wider_px: float,
) -> tuple[Look, Look]:
    """Draw the templates of both spheres; cached, since every pass over a film needs them.

    They are the same wherever in the picture the camera shows them.
    """
    first, second = (_look(sphere, sigma_px, scales, wider_px) for sphere in spheres)
    return first, second


def _look(
    sphere: Sphere, sigma_px: tuple[float, ...], scales: tuple[float, ...], wider_px: float
) -> Look:
    radii = np.array(scales) * sphere.radius_m
    templates = [
        template(blurred_profiles((sigma + wider_px) / float(radius)), coefficients)
        for sigma, radius, coefficients in zip(sigma_px, radii, sphere.shading, strict=True)
    ]
    discs, surfaces = draw(templates, sphere.reliefs, float(radii[0]))
    return Look(
        radius_m=sphere.radius_m,
        markers=np.ascontiguousarray(sphere.markers),
        alpha=sphere.alpha,
        darkness=sphere.darkness,
        discs=discs,
        surfaces=surfaces,
        sigma_px=np.array(sigma_px),
    )


def profiles_of(known: Appearance, sphere: int) -> Floats:
    """Return the blurred radial functions of a sphere in each view (`shading.Profiles`).

    Shape (V, steps, radials); 0 behind the reach of a view's blur.
    """
    radii = known.camera.optics.scales * known.spheres[sphere].radius_m
    each = [
        blurred_profiles(float(sigma / radius)).values
        for sigma, radius in zip(known.sigma_px, radii, strict=True)
    ]
    whole = np.zeros((len(each), max(map(len, each)), each[0].shape[1]))
    for view, values in enumerate(each):
        whole[view, : len(values)] = values
    return whole


FORMAT = 6
SPHERES = ("a", "b")
OWN = tuple(f.name for f in fields(Appearance) if f.name not in {"camera", "spheres"})
"""Numbers that are the pair's own."""
TUPLES = {"middle", "camera_sigma"}


def write_knowledge(file: IO[bytes], known: Appearance) -> None:
    """Write an uncompressed NPZ: every number as it is, in double precision."""
    parts: dict[str, Any] = {
        "format": FORMAT,
        "views": [view.value for view in known.camera.views],
        **{name: getattr(known, name) for name in OWN},
        **{f"optics.{name}": value for name, value in known.camera.optics._asdict().items()},
    }
    for letter, sphere in zip(SPHERES, known.spheres, strict=True):
        parts |= {f"{letter}.{f.name}": getattr(sphere, f.name) for f in fields(Sphere)}
    np.savez(file, allow_pickle=False, **parts)


def read_knowledge(path: Path) -> Appearance:
    """Return what `write_knowledge` has written, equal to the last bit.

    Raises
    ------
    InputError
        The file cannot be read, or is of another format.
    """
    try:
        _require_small(path)
        with path.open("rb") as file, np.load(file, allow_pickle=False) as parts:
            if int(parts["format"]) != FORMAT:
                raise InputError(path, f"format {int(parts['format'])}, {FORMAT} can be read")
            own: dict[str, Any] = {name: _plain(name, parts[name]) for name in OWN}
            optics: dict[str, Any] = {n: _plain(n, parts[f"optics.{n}"]) for n in Optics._fields}
            camera = Camera(tuple(View(str(name)) for name in parts["views"]), Optics(**optics))
            a, b = (_sphere(parts, letter) for letter in SPHERES)
            return Appearance(camera=camera, spheres=(a, b), **own)
    except InputError:
        raise
    # A damaged archive makes the library raise whatever its parsers stumble over.
    except Exception as error:
        raise InputError(path, f"holds nothing that was learned of a pair: {error}") from error


def _require_small(path: Path) -> None:
    """Refuse an archive that unpacks to more than its bytes, or to more than a document may have.

    What is learned is written as it is; packed, a few bytes could become any number.
    """
    most = 1e6 * file_limits().document_mb
    with ZipFile(path) as archive:
        unpacked = sum(entry.file_size for entry in archive.infolist())
    if unpacked > min(most, path.stat().st_size):
        raise ValueError(f"its parts unpack to {unpacked} bytes")


def _sphere(parts: Mapping[str, Floats], letter: str) -> Sphere:
    names = [f.name for f in fields(Sphere)]
    own: dict[str, Any] = {name: _plain(name, parts[f"{letter}.{name}"]) for name in names}
    return Sphere(**own)


def _plain(name: str, value: Floats) -> Floats | float | int | tuple[float, ...]:
    if name in TUPLES:
        return tuple(map(float, value))
    if value.ndim:
        return value
    number: float | int = value.item()
    return number
