"""What a theory of the launch foretells of shots, with its derivatives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.launch.muzzle import LaunchLaw, Muzzle
from analysis.launch.settings import LaunchSettings
from analysis.launch.theory import LaunchTheory
from analysis.launch.touch import Ground, touch

_MUZZLE_STEP = np.array([1e-6] * 6 + [1e-3] * 6 + [1e-7] * 5)


@dataclass(frozen=True, slots=True, eq=False)
class PredictedTouch:
    """S shots as the theory has them.

    Attributes
    ----------
    muzzle
        Both spheres at their mouths.
    touch
        At first touch, numbers of `launch.touch`, shape (S, 17).
    by_muzzle
        Derivative H of the touch by the row of the muzzle, shape (S, 17, 17).
    by_theory
        Derivative of the touch by the theory's parameters, shape (S, 17, P).
    """

    muzzle: Muzzle
    touch: Floats
    by_muzzle: Floats
    by_theory: Floats


def predict_touch(theory: LaunchTheory, settings: LaunchSettings, ground: Ground) -> PredictedTouch:
    """Foretell shots from their settings."""
    muzzle = theory.launch(settings, ground)
    here = touch(muzzle, theory.law, ground)
    vector, columns = theory.vector, []
    for k, step in enumerate(theory.steps):
        shifted = vector.copy()
        shifted[k] += step
        columns.append((theory.at(shifted).touch(settings, ground) - here) / step)
    by_muzzle = _touch_by_muzzle(muzzle, theory.law, ground, here)
    return PredictedTouch(muzzle, here, by_muzzle, np.stack(columns, axis=-1))


def _touch_by_muzzle(muzzle: Muzzle, law: LaunchLaw, ground: Ground, here: Floats) -> Floats:
    row, columns = muzzle.row, []
    for k, step in enumerate(_MUZZLE_STEP):
        moved = row.copy()
        moved[:, k] += step
        columns.append((touch(Muzzle.of_row(moved), law, ground) - here) / step)
    return np.stack(columns, axis=-1)
