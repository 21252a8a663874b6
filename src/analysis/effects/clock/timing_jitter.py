"""Frames taken a little early or late, each by chance: noise that both spheres share."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.effects.effect import Parameter, ScatterEffect, Values


def whiten(columns: Floats, along_track: Floats, values: Values) -> Floats:
    """Whiten numbers of unit noise once more, with the noise of the frames' times in.

    A frame's error of time t moves all its L numbers by d t, d their whitened rates. Noise and
    jitter together have the covariance 1 + s^2 d d', s the jitter. Its inverse root leaves what is
    across d and divides what is along d by sqrt(1 + s^2 d'd).

    Parameters
    ----------
    columns
        Whitened residuals or derivatives, (S, N, C), N = F L with frames outermost.
    along_track
        d, 1/s, (S, F, L).
    values
        s, in s, shape (1,).

    Returns
    -------
    Shape (S, N, C).
    """
    shots, frames, length = along_track.shape
    framed = columns.reshape(shots, frames, length, -1)
    square = (along_track**2).sum(axis=-1)
    safe = np.where(square > 0, square, 1.0)
    share = (1.0 - 1.0 / np.sqrt(1.0 + values[0] ** 2 * square)) / safe
    along = np.einsum("sfl,sflc->sfc", along_track, framed)
    less = along_track[..., None] * (share[..., None] * along)[:, :, None]
    return np.asarray((framed - less).reshape(columns.shape))


EFFECT = ScatterEffect(
    name="timing-jitter",
    title="Jitter of the frames' times",
    parameters=(
        Parameter(
            symbol="s",
            unit="s",
            meaning="standard deviation of a frame's time",
            plausible=(0.0, 5e-5),
            step=1e-7,
            one_sided=True,
        ),
    ),
    formula="x(t + d), R(t + d) with d Gaussian, of its own in each frame, common to both spheres",
    source="kinematics; a trigger polled or a clock divided is uncertain by some microseconds",
    gives_away="residuals along both tracks rise and fall together, in proportion to the speeds",
    confused_with=("block-readout", "exposure-offset"),
    whiten=whiten,
)
