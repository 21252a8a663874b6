"""What the cells of lack of fit add up to, part by part, and what two shots carry of each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from analysis.arrays import Floats
from analysis.collision.operator import surface_velocity
from analysis.model.data.parts import Kept
from analysis.model.data.stream import CampaignData
from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.fit import Fit, parts_of
from analysis.model.fitting.normal import inverse, with_prior
from analysis.model.fitting.slow_errors.field import field_errors
from analysis.model.predict.state import ShotStates
from analysis.model.rank.projector import ByShot, ColumnSums, Eliminated, Solved, eliminated
from analysis.model.structure.channels import (
    SMOOTH,
    FrameChannel,
    contact_columns,
    frame_channels,
)
from analysis.model.structure.reach import Reach, reach_of

LEAST_SPEED = 1e-3


def shot_covariates(data: Data, states: ShotStates) -> dict[str, Floats]:
    """Return every covariate of the shots, each of shape (S,), taken from the prediction.

    Never from the observed pose: its noise would be in the covariate and in the residual at once.
    ln v_n, ln(v_s / v_n), spins along v_t x n and along n, where the contact was (rig axes, m), and
    what the shot list holds. A table does not say where the contact was, and scalars nothing of the
    spins.
    """
    before = states.before
    relative = before.velocity_b - before.velocity_a
    approach = np.maximum(-(relative * states.normal).sum(axis=1), LEAST_SPEED)
    surface = surface_velocity(before, states.normal, data.bodies)
    sliding = np.maximum(np.linalg.norm(surface, axis=1), LEAST_SPEED)
    across = relative + approach[:, None] * states.normal
    length = np.maximum(np.linalg.norm(across, axis=1, keepdims=True), LEAST_SPEED)
    roll_axis = np.cross(across / length, states.normal)
    speeds = {"ln v_n": np.log(approach), "ln v_s/v_n": np.log(sliding / approach)}
    spins = {
        "spin along v_t x n": ((before.spin_a + before.spin_b) * roll_axis).sum(axis=1),
        "spin about n": ((before.spin_b - before.spin_a) * states.normal).sum(axis=1),
    }
    if isinstance(data, ContactTable):
        return {**speeds, **({} if data.scalars else spins), **data.covariates}
    places = {f"contact {axis}": states.point[:, k] for k, axis in enumerate("XYZ")}
    return {**speeds, **spins, **places, **data.covariates}


Name = tuple[str, str]
"""Of a cell: what is disturbed, and against what."""

CARRIERS = 2
LEAST_WIDTH = 1e-12
"""Of a covariate that varies."""


@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """Along what frames of a covariate lie, by `FrameChannel.lines`, and in which unit."""

    unit: str
    sums: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Told:
    """What the shots of one part say to the cells: jumps at contact, and gradients of frames.

    Attributes
    ----------
    jumps
        By shot, a column for each jump.
    curves
        Gradients of the columns of each channel of frames, shape (S, Q, 5).
    """

    jumps: ByShot
    curves: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Smooth:
    """Five Chebyshev polynomials of a covariate of shots, on its 1 to 99 per cent range."""

    low: float
    high: float

    @classmethod
    def of(cls, values: Floats) -> Smooth:
        """Return those on the range of the values of all shots."""
        return cls(*(float(end) for end in np.quantile(values, [0.01, 0.99])))

    def functions(self, values: Floats) -> Floats:
        """Return them at some values, shape (S, 5); a covariate that never changes is one, 1."""
        if self.high - self.low < LEAST_WIDTH:
            return np.ones((len(values), 1))
        scaled = np.clip(2 * (values - self.low) / (self.high - self.low) - 1, -1, 1)
        return np.asarray(chebyshev.chebvander(scaled, SMOOTH - 1))


@dataclass(frozen=True, slots=True, eq=False)
class Summed:
    """All cells of a fit: what they add up to, and what each shot says to them.

    Attributes
    ----------
    jumps
        Names of the jumps, and of the channels of frames with their covariates in `curves`.
    covariates
        Of all shots, each of shape (S,).
    cells
        Sums of each cell, by its name.
    lines
        Of the channels of frames, by the cell's name.
    information, known
        On the shared parameters, those of the field of errors behind those of the fit, the prior
        not in, shape (P, P); what the prior adds to its diagonal, shape (P,).
    left
        As `Projector` has it, shape (P,).
    told
        Part by part.
    """

    jumps: tuple[str, ...]
    curves: tuple[Name, ...]
    reach: Reach
    covariates: dict[str, Floats]
    cells: dict[Name, ColumnSums]
    lines: dict[Name, Lines]
    information: Floats
    known: Floats
    left: Floats
    told: Kept[Told]

    def covariance(self) -> Floats:
        """Return that of the shared parameters, the prior in, shape (P, P)."""
        return inverse(with_prior(self.information, self.known))

    def carried(self, solved: Mapping[Name, Solved], covariance: Floats) -> dict[Name, float]:
        """Return the share of each cell's fall that is gone without its two loudest shots."""
        loudest: dict[Name, list[tuple[float, Floats]]] = {name: [] for name in solved}
        for name, share, gradient in self._by_shot(solved):
            first = np.argsort(share)[-CARRIERS:]
            own = loudest[name] + [(float(share[s]), gradient[s].copy()) for s in first]
            loudest[name] = sorted(own, key=lambda entry: entry[0])[-CARRIERS:]
        found = {}
        for name, one in solved.items():
            sums = self.cells[name]
            rest = sums.gradient - sums.against @ (covariance @ self.left)
            rest = rest - np.sum([gradient for _, gradient in loudest[name]], axis=0)
            kept = float(rest @ one.covariance @ rest)
            found[name] = 1.0 - kept / one.chi2 if one.chi2 > 0 else 0.0
        return found

    def _by_shot(self, solved: Mapping[Name, Solved]) -> Iterator[tuple[Name, Floats, Floats]]:
        """Yield each cell's share of its fall by shot, (S,), and gradient, (S, C), by part."""
        smooth = {name: Smooth.of(values) for name, values in self.covariates.items()}
        start = 0
        for part in self.told:
            own = slice(start, start := start + len(part.curves))
            for covariate, values in self.covariates.items():
                basis = smooth[covariate].functions(values[own])
                for k, jump in enumerate(self.jumps):
                    gradient = basis * part.jumps.gradient[:, k, None]
                    name = jump, covariate
                    yield name, gradient @ solved[name].amplitudes, gradient
            for k, name in enumerate(self.curves):
                gradient = part.curves[:, k]
                yield name, gradient @ solved[name].amplitudes, gradient


def summed(data: CampaignData, fit: Fit) -> Summed:
    """Go over a campaign and add up what each cell's columns do."""
    reach, theory = reach_of(data, fit), fit.theory
    each = [shot_covariates(part, states) for part, states in parts_of(data, fit)]
    covariates = {name: np.concatenate([own[name] for own in each]) for name in each[0]}
    smooth = {name: Smooth.of(values) for name, values in covariates.items()}
    field = field_errors(data)
    centre, known = theory.prior
    strain, known = field.beside((theory.vector - centre) * known, known)
    size, start = len(strain), 0
    information, downhill = np.zeros((size, size)), np.zeros(size)
    cells: dict[Name, ColumnSums] = {}
    lines: dict[Name, Lines] = {}
    told = data.keep(Told)
    for part, states in parts_of(data, fit):
        own = slice(start, start := start + part.count)
        sums, added, pulled = eliminated(part, states, theory, field)
        information += added
        downhill += pulled
        contact = contact_columns(part, states, theory)
        jumps = sums.project(np.concatenate(list(contact.values()), axis=2))
        functions = {name: one.functions(covariates[name][own]) for name, one in smooth.items()}
        _add(cells, _cells_of_jumps(jumps, tuple(contact), functions))
        channels = frame_channels(part, states, theory, reach)
        curves = _project(sums, channels)
        _add(cells, {_name(c): ColumnSums.of(one) for c, one in zip(channels, curves, strict=True)})
        _add_lines(lines, channels, reach)
        told.append(Told(jumps, _gradients(curves, part.count)))
    return Summed(
        jumps=tuple(contact),
        curves=tuple(_name(channel) for channel in channels),
        reach=reach,
        covariates=covariates,
        cells=cells,
        lines=lines,
        information=information,
        known=known,
        left=downhill - strain,
        told=told,
    )


def _name(channel: FrameChannel) -> Name:
    return channel.name, channel.covariate


def _project(sums: Eliminated, channels: Sequence[FrameChannel]) -> list[ByShot]:
    return [sums.project(channel.columns()) for channel in channels]


def _gradients(curves: Sequence[ByShot], shots: int) -> Floats:
    if not curves:
        return np.zeros((shots, 0, SMOOTH))
    return np.stack([one.gradient for one in curves], axis=1)


def _add(cells: dict[Name, ColumnSums], more: Mapping[Name, ColumnSums]) -> None:
    for name, sums in more.items():
        cells[name] = cells[name] + sums if name in cells else sums


def _add_lines(lines: dict[Name, Lines], channels: Sequence[FrameChannel], reach: Reach) -> None:
    """Add the lines of each covariate, alike in all channels that hang on it."""
    alike: dict[str, Floats] = {}
    for channel in channels:
        if channel.covariate not in alike:
            alike[channel.covariate] = channel.lines(reach)
        sums, name = alike[channel.covariate], _name(channel)
        before = lines[name].sums if name in lines else 0.0
        lines[name] = Lines(channel.unit, sums + before)


def _cells_of_jumps(
    jumps: ByShot, names: Sequence[str], functions: Mapping[str, Floats]
) -> dict[Name, ColumnSums]:
    """Add up each jump times each covariate's functions over the shots of a part."""
    shots, count = jumps.gradient.shape
    own = np.ascontiguousarray(np.diagonal(jumps.own, axis1=1, axis2=2))
    against = jumps.against.reshape(shots, -1)
    found: dict[Name, ColumnSums] = {}
    for covariate, basis in functions.items():
        size = basis.shape[1]
        pairs = (basis[:, :, None] * basis[:, None, :]).reshape(shots, -1)
        squares = (pairs.T @ own).reshape(size, size, count)
        raw, gradient = (basis**2).T @ jumps.raw, basis.T @ jumps.gradient
        met = (basis.T @ against).reshape(size, count, -1)
        for k, jump in enumerate(names):
            found[jump, covariate] = ColumnSums(
                squares[:, :, k], met[:, k], gradient[:, k], raw[:, k]
            )
    return found
