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

from analysis.effects.effect import BodyEffect, CameraEffect, ClockEffect, Effect, FlightEffect
from analysis.model.comparison import Comparison, Frames, Snapshot, by_block, weights
from analysis.model.contact import contact_outcome
from analysis.model.poses import PoseData
from analysis.model.prediction import appear, displaced, exposed, perturbation, rate
from analysis.model.sides import flights_by_outcome
from analysis.model.state import ShotStates
from analysis.model.systematics import Systematic
from analysis.model.tables import Data
from analysis.model.theory import LAW, Active, Theory

Floats = NDArray[np.float64]


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

    def joined(self, other: Columns) -> Columns:
        """Return these columns followed by others."""
        return Columns(
            moved=np.concatenate([self.moved, other.moved], axis=2),
            framed=np.concatenate([self.framed, self.moved.shape[2] + other.framed]),
            frames=np.concatenate([self.frames, other.frames], axis=3),
            pulled=np.concatenate([self.pulled, other.pulled], axis=2),
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

    def _flat(self) -> Floats:
        shots, blocks, length, count = self.frames.shape
        return self.frames.reshape(shots, blocks * length, count)


def columns_of(line: Comparison, moved: Floats, frames: Sequence[tuple[int, Floats]]) -> Columns:
    """Put columns together: changes of the flights (S, 48, K), and by number those of frames."""
    framed = np.array([k for k, _ in frames], dtype=np.intp)
    shape = line.residual.shape
    stacked = np.zeros((*shape, 0))
    if frames:
        stacked = line.recast(np.stack([c for _, c in frames], axis=-1))
    pulled = np.zeros_like(moved)
    if frames:
        pulled[:, :, framed] = line.pull(stacked)
    return Columns(moved, framed, stacked, pulled)


def no_columns(line: Comparison) -> Columns:
    """Return an empty set of columns: nothing that the shots share is to move."""
    return columns_of(line, line.by_state[..., :0], ())


def theory_columns(
    data: Data, states: ShotStates, theory: Theory, line: Comparison, here: Snapshot
) -> Columns:
    """Differentiate by every shared parameter of a theory that is about `here`."""
    trials = [(None, k) for k in range(len(LAW))]
    owners = [(a, j) for a in theory.parts for j in range(len(a.values))]
    return _differences(data, states, theory, line=line, here=here, wanted=[*trials, *owners])


def candidate_columns(
    data: Data,
    states: ShotStates,
    theory: Theory,
    *,
    line: Comparison,
    here: Snapshot,
    effects: Sequence[Effect],
) -> Columns:
    """Differentiate by the parameters of effects that are not in the theory, where they are off."""
    wanted = [(Active(e, e.off), j) for e in effects for j in range(len(e.parameters))]
    return _differences(data, states, theory, line=line, here=here, wanted=wanted)


def _differences(
    data: Data,
    states: ShotStates,
    theory: Theory,
    *,
    line: Comparison,
    here: Snapshot,
    wanted: Sequence[tuple[Active | Systematic | None, int]],
) -> Columns:
    outcomes, places = [], []
    frames: list[tuple[int, Floats]] = []
    weight = weights(data) if isinstance(data, PoseData) else None
    for k, (active, j) in enumerate(wanted):
        moved, step = _shifted(theory, active, j)
        if active is not None and active.effect.stage != "contact":
            # A table of contacts has no frames: nothing in it hangs on how they came about.
            if here.frames is not None and weight is not None and isinstance(data, PoseData):
                change = _change(data, theory, moved, here=here.frames, effect=active.effect)
                frames.append((k, by_block(change * (weight / step))))
            continue
        outcomes.append((contact_outcome(data, states, moved) - here.outcome) / step)
        places.append(k)
    sides = np.zeros((len(data.shots), line.by_state.shape[1], len(wanted)))
    if outcomes:
        change = np.stack(outcomes, axis=-1)
        sides[:, :, places] = flights_by_outcome(states, here.outcome, change)
    return columns_of(line, sides, frames)


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


def _change(
    data: PoseData,
    theory: Theory,
    moved: Theory,
    *,
    here: Frames,
    effect: Effect,
) -> Floats:
    """Return what a step of an effect of flight, camera or clock does to frames, (S, F, 2, 6)."""
    if isinstance(effect, ClockEffect):
        return _later(data, theory, moved, here)
    position = here.flown.position
    if theory.flight:
        position = position + perturbation(data, here.flown, theory.flight)[0]
    turned = np.zeros_like(position)
    if isinstance(effect, FlightEffect):
        old = [(e, v) for e, v in theory.flight if e is effect]
        new = [(e, v) for e, v in moved.flight if e is effect]
        push, turned = perturbation(data, here.flown, new)
        if old:
            before = perturbation(data, here.flown, old)
            push, turned = push - before[0], turned - before[1]
        position = position + push
    elif not isinstance(effect, CameraEffect | BodyEffect):
        raise TypeError(f"effect {effect.name!r} acts in no known stage")
    position = displaced(data, here.flown, position, moved.body)
    change = appear(data, position, moved.camera) - here.poses.position
    return np.concatenate([change, turned], axis=-1)


def _later(data: PoseData, theory: Theory, moved: Theory, here: Frames) -> Floats:
    """Return what other true times do to frames, to first order, (S, F, 2, 6)."""
    flown = here.flown
    before, after = (exposed(data, flown.stated, flown.position, t.clock) for t in (theory, moved))
    shift = rate(data, flown) * (after.position - before.position)
    place = flown.position
    if theory.flight:
        place = place + perturbation(data, flown, theory.flight)[0]
    place = displaced(data, flown, place + shift, theory.body)
    change = appear(data, place, theory.camera) - here.poses.position
    turned = flown.spin * (after.rotation - before.rotation)[..., None]
    return np.concatenate([change, turned], axis=-1)
