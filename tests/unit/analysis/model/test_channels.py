"""The columns of unnamed causes against poses that are disturbed by hand."""

import numpy as np
import pytest

from analysis.model.fitting.fit import fit_campaign
from analysis.model.predict.contact import AFTER, contact_outcome
from analysis.model.predict.prediction import predict
from analysis.model.structure.channels import contact_columns, contact_frame, whitened
from analysis.model.structure.layout import AXES
from analysis.motion.rotation import rotation_matrix, rotation_vector
from tests.unit.analysis.model.hard_spheres import campaign

STEP = 1e-3
"""rad/s."""


@pytest.mark.parametrize(("word", "shares"), [("relative", (-0.5, 0.5)), ("common", (1.0, 1.0))])
def test_a_jump_of_spin_turns_the_spheres_as_spinning_faster_after_contact_does(
    word: str, shares: tuple[float, float]
) -> None:
    data = campaign(6, 12)
    fit = fit_campaign(data)
    poses = predict(data, fit.states, fit.theory)
    spins = contact_outcome(data, fit.states, fit.theory)[:, AFTER].reshape(-1, 4, 3)[:, 2:]
    tau = np.maximum(data.times_s - fit.states.time_s[:, None], 0.0)[:, :, None, None]
    columns, frame = contact_columns(data, fit.states, fit.theory), contact_frame(data, fit.states)
    for name, axis in zip(AXES, frame, strict=True):
        faster = spins + STEP * np.multiply.outer(shares, axis).swapaxes(0, 1)
        at_touch = rotation_matrix(-spins[:, None] * tau) @ poses.rotation
        moved = rotation_matrix(faster[:, None] * tau) @ at_touch
        turned = rotation_vector(moved @ np.swapaxes(poses.rotation, -1, -2)) / STEP
        change = np.concatenate([np.zeros_like(turned), turned], axis=-1)
        expected = whitened(data, change)
        found = columns[f"{word} spin {name}"][..., 0]
        assert found == pytest.approx(expected, abs=1e-4 * np.abs(expected).max())
