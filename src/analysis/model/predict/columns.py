"""Derivatives of all poses by numbers that shots share, each kept as small as its stage allows.

What acts at contact changes the 48 numbers of the flights; what acts in flight, camera or clock
changes frames. Sums over residuals of a product of two columns then need the frames of the second
kind alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.effects.effect import (
    BodyEffect,
    CameraEffect,
    ClockEffect,
    Effect,
    FlightEffect,
    OrientationEffect,
)
from analysis.model.data.poses import PoseData
from analysis.model.data.tables import Data
from analysis.model.fitting.systematics import Systematic
from analysis.model.loops import plain
from analysis.model.loops.misfit import put_whitened
from analysis.model.predict.comparison import KINDS, Comparison, Frames, Snapshot, weights
from analysis.model.predict.contact import outcome_of_slopes
from analysis.model.predict.prediction import Change, appear, displaced, exposed, rate
from analysis.model.predict.sides import flights_by_outcome
from analysis.model.predict.state import ShotStates
from analysis.model.predict.theory import BETA0, LAW, Active, Theory


@dataclass(frozen=True, slots=True, eq=False)
class Unmoved:
    """A theory and what frames show of it: where the steps of all parameters start."""

    theory: Theory
    here: Frames

    @property
    def position(self) -> Floats:
        """Centres of mass, m, with what small forces do on the way, shape (S, F, 2, 3)."""
        flown, flight = self.here.flown, self.theory.flight
        return flown.position + self.here.way.pushed(flight)[0] if flight else flown.position

    def change(self, moved: Theory, effect: Effect) -> Change:
        """Return what a theory with other values of an effect changes.

        Positions, m, and orientations, rad, shape (S, F, 2, 3); None: no orientation.
        """
        if isinstance(effect, ClockEffect):
            return self._later(moved)
        if isinstance(effect, OrientationEffect):
            return self._turned(moved)
        way, turned = self.here.way, None
        position = self.position
        if isinstance(effect, FlightEffect):
            # An error of the air may be in beside a candidate of the same name.
            old, new = ([(e, v) for e, v in t.flight if e is effect] for t in (self.theory, moved))
            pushed, turned = way.pushed(new)
            before, turned_before = way.pushed(old)
            position, turned = position + (pushed - before), _less(turned, turned_before)
        elif not isinstance(effect, CameraEffect | BodyEffect):
            raise TypeError(f"effect {effect.name!r} acts in no known stage")
        position = displaced(way.data, way.flown, position, moved.body)
        return appear(way.data, position, moved.camera) - self.here.poses.position, turned

    def _turned(self, moved: Theory) -> Change:
        """Return what other turns of the orientations that are seen do, to first order."""
        where = self.here.poses.position
        old, new = (0.0 if r is None else r for r in (self.theory.orientation, moved.orientation))
        return np.zeros_like(where), np.broadcast_to(new - old, where.shape)

    def _later(self, moved: Theory) -> Change:
        """Return what other true times do, to first order."""
        data, flown = self.here.way.data, self.here.way.flown
        before, after = (
            exposed(data, flown.stated, flown.position, t.clock) for t in (self.theory, moved)
        )
        place = self.position + rate(data, flown) * (after.position - before.position)
        place = displaced(data, flown, place, self.theory.body)
        change = appear(data, place, self.theory.camera) - self.here.poses.position
        return change, flown.spin * (after.rotation - before.rotation)[..., None]


def _less(turned: Floats | None, before: Floats | None) -> Floats | None:
    if before is None:
        return turned
    return -before if turned is None else turned - before


Wanted = tuple[Active | Systematic | None, int]
"""One parameter: of which part of a theory (None: of the law), and its number there."""


@dataclass(frozen=True, slots=True, eq=False)
class Columns:
    """K columns of derivatives, over sigma.

    Attributes
    ----------
    moved
        Changes of the 48 numbers, shape (S, 48, K); zero for a column of frames.
    framed
        Which columns change frames, shape (K',).
    frames
        These, shape (S, B, L, K').
    pulled
        slopes' frames, shape (S, 48, K); zero for the other columns.
    """

    moved: Floats
    framed: NDArray[np.intp]
    frames: Floats
    pulled: Floats

    def with_frames(self, line: Comparison, frames: Floats, place: int) -> Columns:
        """Return the columns with more of frames, (S, 4, 3 F, K), set in at a place."""
        count = frames.shape[-1]
        more = columns_of(line, np.zeros((*self.moved.shape[:2], count)), np.arange(count), frames)
        framed = np.where(self.framed < place, self.framed, self.framed + count)
        return Columns(
            moved=np.insert(self.moved, [place] * count, 0.0, axis=2),
            framed=np.concatenate([framed, place + np.arange(count)]),
            frames=np.concatenate([self.frames, more.frames], axis=3),
            pulled=np.concatenate(
                [self.pulled[:, :, :place], more.pulled, self.pulled[:, :, place:]], axis=2
            ),
        )

    def against_flights(self, line: Comparison) -> Floats:
        """Return slopes' columns, shape (S, 48, K)."""
        return line.weigh(self.moved) + self.pulled

    def with_residual(self, line: Comparison) -> Floats:
        """Return columns' residual, shape (S, K)."""
        product = (np.swapaxes(self.moved, 1, 2) @ line.pulled[..., None])[..., 0]
        flat = self._flat()
        residual = line.residual.reshape(len(flat), -1, 1)
        product[:, self.framed] += (np.swapaxes(flat, 1, 2) @ residual)[..., 0]
        return np.asarray(product)

    def gram(self, line: Comparison) -> Floats:
        """Return columns' columns, shape (S, K, K)."""
        moved = np.swapaxes(self.moved, 1, 2)
        product = moved @ self.against_flights(line) + np.swapaxes(self.pulled, 1, 2) @ self.moved
        flat = self._flat()
        rows, columns = np.ix_(self.framed, self.framed)
        product[:, rows, columns] += np.swapaxes(flat, 1, 2) @ flat
        return product

    def whole_gram(self, line: Comparison) -> Floats:
        """Return the same of all shots together, shape (K, K)."""
        product = np.zeros(2 * self.moved.shape[2:])
        flown = np.setdiff1d(np.arange(len(product)), self.framed)
        moved, pulled = self.moved[:, :, flown], self.pulled[:, :, self.framed]
        rows = moved.reshape(moved.shape[0] * moved.shape[1], -1)
        product[np.ix_(flown, flown)] = rows.T @ line.weigh(moved).reshape(rows.shape)
        between = rows.T @ pulled.reshape(len(rows), -1)
        product[np.ix_(flown, self.framed)] = between
        product[np.ix_(self.framed, flown)] = between.T
        flat = self.frames.reshape(line.residual.size, -1)
        product[np.ix_(self.framed, self.framed)] = flat.T @ flat
        return product

    def _flat(self) -> Floats:
        shots, blocks, length, count = self.frames.shape
        return self.frames.reshape(shots, blocks * length, count)


def columns_of(
    line: Comparison, moved: Floats, framed: NDArray[np.intp], frames: Floats
) -> Columns:
    """Put columns together: changes of the flights (S, 48, K), and by number those of frames.

    Parameters
    ----------
    frames
        By spheres and kinds, not yet whitened for shared noise, shape (S, 4, L, K').
    """
    if not framed.size:
        return Columns(moved, framed, np.zeros((*line.residual.shape, 0)), np.zeros_like(moved))
    frames, pulled = line.recast(frames), np.zeros_like(moved)
    pulled[:, :, framed] = line.pull(frames)
    return Columns(moved, framed, frames, pulled)


def no_columns(line: Comparison) -> Columns:
    """Return an empty set of columns: nothing that the shots share is to move."""
    none = np.zeros(0, dtype=np.intp)
    return columns_of(line, line.by_state[..., :0], none, line.slopes[..., :0])


def theory_columns(
    data: Data, states: ShotStates, theory: Theory, line: Comparison, here: Snapshot
) -> Columns:
    """Differentiate by every shared parameter of a theory that is about `here`."""
    return _differences(data, states, theory, line=line, here=here, wanted=_own(theory))


def systematic_columns(
    data: Data, states: ShotStates, theory: Theory, line: Comparison, here: Snapshot
) -> Columns:
    """Differentiate by what measuring and the air leave, of a theory that is about `here`."""
    wanted: list[Wanted] = [(s, j) for s in theory.systematics for j in range(len(s.values))]
    return _differences(data, states, theory, line=line, here=here, wanted=wanted)


def _own(theory: Theory) -> list[Wanted]:
    law: list[Wanted] = [(None, k) for k in range(len(LAW))]
    return law + [(a, j) for a in theory.parts for j in range(len(a.values))]


def all_columns(
    data: Data,
    states: ShotStates,
    theory: Theory,
    *,
    line: Comparison,
    here: Snapshot,
    effects: Sequence[Effect],
    given: Floats | None = None,
) -> Columns:
    """Differentiate by those, then by the parameters of effects not in the theory, where off.

    Parameters
    ----------
    given
        Columns of frames that come between the two, by spheres and kinds, not yet whitened for
        shared noise, shape (S, 4, 3 F, K).
    """
    off: list[Wanted] = [(Active(e, e.off), j) for e in effects for j in range(len(e.parameters))]
    own = _own(theory)
    found = _differences(data, states, theory, line=line, here=here, wanted=own + off)
    if given is None or not given.shape[-1]:
        return found
    return found.with_frames(line, given, len(own))


def _differences(
    data: Data,
    states: ShotStates,
    theory: Theory,
    *,
    line: Comparison,
    here: Snapshot,
    wanted: Sequence[Wanted],
) -> Columns:
    acting = [None if active is None else active.effect for active, _ in wanted]
    at_contact = [k for k, e in enumerate(acting) if e is None or e.stage == "contact"]
    if theory.contact_law is not None:
        # Such a law has no beta0.
        at_contact = [k for k in at_contact if wanted[k] != (None, BETA0)]
    moved = np.zeros((len(data.shots), line.by_state.shape[1], len(wanted)))
    if at_contact:
        outcomes = []
        for k in at_contact:
            shifted, step = _shifted(theory, *wanted[k])
            outcomes.append((outcome_of_slopes(data, states, shifted) - here.about) / step)
        change = flights_by_outcome(here.outcome, np.stack(outcomes, axis=-1))
        moved[:, :, at_contact] = change
    framed = np.array(
        [k for k, e in enumerate(acting) if e and e.stage != "contact"], dtype=np.intp
    )
    if not isinstance(data, PoseData) or here.frames is None:
        # A table of contacts has no frames: nothing in it hangs on how they came about.
        framed = framed[:0]
        return columns_of(line, moved, framed, line.slopes[..., :0])
    unmoved, weight = Unmoved(theory, here.frames), weights(data)
    steps = [(acting[k], *_shifted(theory, *wanted[k])) for k in framed]
    frames = _frame_columns(unmoved, weight, [(e, t, s) for e, t, s in steps if e is not None])
    return columns_of(line, moved, framed, frames)


def _frame_columns(
    unmoved: Unmoved, weight: Floats, steps: Sequence[tuple[Effect, Theory, float]]
) -> Floats:
    """Differentiate by steps of effects of frames, over sigma, shape (S, 4, 3 F, K').

    Column by column in memory: they are made so, and multiply each other so.
    """
    shots, frames = weight.shape[:2]
    columns = np.zeros((len(steps), shots, KINDS, 3 * frames))
    for column, (effect, moved, step) in zip(columns, steps, strict=True):
        for kind, change in enumerate(unmoved.change(moved, effect)):
            if change is not None:
                put_whitened(plain(change), weight, kind, step, column)
    return np.moveaxis(columns, 0, -1)


def _shifted(
    theory: Theory, active: Active | Systematic | None, number: int
) -> tuple[Theory, float]:
    """Return the theory a small step along one parameter, and the step."""
    if active is None:
        vector, step = theory.vector, float(theory.steps[number])
        vector[number] += step
        return theory.at(vector), step
    parameter = active.effect.parameters[number]
    values = active.values.copy()
    values[number] += parameter.step
    moved = replace(active, values=values)
    parts = [moved if a is active else a for a in theory.parts]
    if all(a is not moved for a in parts):
        parts.append(moved)
    granted = tuple(a for a in parts if isinstance(a, Systematic))
    added = tuple(a for a in parts if isinstance(a, Active))
    return Theory(theory.law, granted, added), parameter.step
