"""A fit against its campaign, stage by stage.

Flight and camera are held by smooth displacements fitted to the residuals. The outcome of every
contact is free meanwhile, so that a wrong law does not pass for them; the shots stand where they
fit best with their outcomes so (`freed`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from analysis import chi_squared
from analysis.arrays import Floats
from analysis.model.agreement.freed import with_free_outcomes
from analysis.model.agreement.outcome import jump_covariance, outcome_rows, outcomes
from analysis.model.agreement.poses import fitted_row, pose_groups, predicted_row, sides
from analysis.model.agreement.table import (
    Agreement,
    Row,
    Spread,
    Stage,
    looked_at_together,
    root_mean,
)
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import CampaignData, whole
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.noise import noise_scales
from analysis.model.fitting.normal import with_prior
from analysis.model.fitting.slow_errors.field import field_errors
from analysis.model.rank.projector import (
    LEAST_INFORMATION,
    ByShot,
    ColumnSums,
    Projector,
    Solved,
    projector,
)
from analysis.model.structure.channels import (
    SMOOTH,
    FrameChannel,
    camera_channels,
    contact_columns,
    flight_channels,
)
from analysis.model.structure.reach import reach_of
from analysis.model.verdict.crossvalidation import prediction_error

Groups = dict[str, list[FrameChannel]]


def agree(campaign: CampaignData, fit: Fit, further: Sequence[Stage] = ()) -> Agreement:
    """Hold a fit against its campaign.

    Parameters
    ----------
    campaign
        Without the frames inside contact (`without_contact_frames`).
    fit
        Of these data, with whatever effects.
    further
        Stages that lie before the first frame, such as `launch_stage`; they stand first, as they
        are.
    """
    data = whole(campaign)
    sums, jumps = projector(data, fit), contact_columns(data, fit.states, fit.theory)
    outcome = outcome_rows(outcomes(sums, jumps), sums.covariance)
    if isinstance(data, ContactTable):
        stages = [Stage("after contact", tuple(outcome))]
    else:
        stages = _of_frames(data, fit, sums, outcome)
    freedom = max(fit.freedom, 1)
    return Agreement(
        stages=(*further, *looked_at_together(stages)),
        chi2=fit.chi2,
        freedom=freedom,
        p_value=float(chi_squared.chance_of_more(fit.chi2, freedom)),
        prediction=prediction_error(data, fit),
        noise=noise_scales(data, fit),
    )


def _of_frames(data: PoseData, fit: Fit, sums: Projector, outcome: Sequence[Row]) -> list[Stage]:
    sigma = np.concatenate([data.position_sigma, data.turn_sigma], axis=-1)
    sigma = np.where(data.measured, sigma, 0.0).reshape(len(sigma), -1)
    free = with_free_outcomes(data, fit)
    unbound, states, theory = projector(free.data, free.fit), free.fit.states, free.fit.theory
    beside_field = projector(free.data, free.fit, field_errors(data))
    jumps, reach = contact_columns(free.data, states, theory), reach_of(free.data, free.fit)
    after = data.times_s > fit.states.time_s[:, None]
    known = (data.measured & ~after[..., None, None]).reshape(len(sigma), -1)
    before = sides(unbound, known).before
    split = sides(sums, known)
    fitted = [fitted_row(before, group, sigma) for group in pose_groups(data.measured, ~after)]
    poses = [predicted_row(split, group, sigma) for group in pose_groups(data.measured, after)]
    shapes = (
        Stage(name, tuple(shape_rows(free.data, beside_field, groups, jumps=jumps, sigma=sigma)))
        for name, groups in (
            ("flight", _flight(free.data, flight_channels(free.data, states, reach))),
            ("camera", _camera(camera_channels(free.data, states, theory, reach))),
        )
    )
    return [
        Stage("before contact", tuple(fitted)),
        Stage("after contact", (*outcome, *poses)),
        *shapes,
    ]


def _flight(data: PoseData, channels: Sequence[FrameChannel]) -> Groups:
    groups: Groups = {}
    for channel in channels:
        if channel.unit == "m" or np.isfinite(data.rotation_sigma).any():
            title = f"{channel.name[:-2]} against time"
            groups.setdefault(title, []).append(channel)
    return groups


def _camera(channels: Sequence[FrameChannel]) -> Groups:
    groups: Groups = {}
    for channel in channels:
        groups.setdefault(f"{channel.name} against place", []).append(channel)
    return groups


def with_free_contacts(sums: Projector, columns: Floats, count: int) -> tuple[Projector, ByShot]:
    """Project columns (S, N, C) with the outcome of every contact free.

    Parameters
    ----------
    columns
        Behind those of the jumps of an outcome.
    count
        Number of the jumps.

    Returns
    -------
    The projector whose covariance has only what the poses without the law say of the shared
    parameters, and what the columns add up to.
    """
    by_shot = sums.project(columns)
    jumped = ByShot(
        own=by_shot.own[:, :count, :count],
        against=by_shot.against[:, :count],
        gradient=by_shot.gradient[:, :count],
        raw=by_shot.raw[:, :count],
    )
    covariance, _ = jump_covariance(jumped)
    coupling = by_shot.own[:, count:, :count] @ covariance
    gradient = by_shot.gradient[:, count:, None] - coupling @ jumped.gradient[..., None]
    reduced = ByShot(
        own=by_shot.own[:, count:, count:] - coupling @ by_shot.own[:, :count, count:],
        against=by_shot.against[:, count:] - coupling @ jumped.against,
        gradient=gradient[..., 0],
        raw=by_shot.raw[:, count:],
    )
    taken = (np.swapaxes(jumped.against, 1, 2) @ covariance @ jumped.against).sum(axis=0)
    flat = sums.shared.reshape(-1, len(sums.covariance))
    information = with_prior(flat.T @ flat, sums.held[1])
    law = _law_covariance(information - taken, np.diag(information))
    return replace(sums, covariance=law), reduced


def _law_covariance(information: Floats, raw: Floats) -> Floats:
    """Invert along what is still informed of the raw information (P,), zero along the rest, (P, P).

    What a free outcome can imitate of the law leaves nothing but rounding, of either sign.
    """
    scale = np.sqrt(np.maximum(raw, 1e-300))
    values, vectors = np.linalg.eigh(information / scale[:, None] / scale)
    told = values > LEAST_INFORMATION
    along = vectors[:, told] / scale[:, None]
    return np.asarray((along / values[told]) @ along.T)


def shape_rows(
    data: PoseData,
    sums: Projector,
    groups: Mapping[str, Sequence[FrameChannel]],
    *,
    jumps: dict[str, Floats],
    sigma: Floats,
) -> Iterator[Row]:
    """Give a row for each named group of channels of one unit; sigma of shape (S, N).

    Its size is the root mean square displacement or turn of a sphere, over all that was measured,
    that these smooth functions would bring; its floor what they bring of noise alone.
    """
    parts = [c.columns() for channels in groups.values() for c in channels]
    columns, first = np.concatenate([*jumps.values(), *parts], axis=2), len(jumps)
    free, by_shot = with_free_contacts(sums, columns, first)
    # Whitened no longer: from here on metres and radians.
    columns *= sigma[..., None]
    start = 0
    for quantity, channels in groups.items():
        own = slice(start, start := start + SMOOTH * len(channels))
        chosen = ByShot(
            own=by_shot.own[:, own, own],
            against=by_shot.against[:, own],
            gradient=by_shot.gradient[:, own],
            raw=by_shot.raw[:, own],
        )
        solved = ColumnSums.of(chosen).solved(free.covariance, free.left)
        moved = columns[..., first + own.start : first + own.stop]
        unit = "mm" if channels[0].unit == "m" else "mrad"
        yield _row((quantity, unit), solved, moved.reshape(-1, moved.shape[2]))


def _row(title: tuple[str, str], solved: Solved, moved: Floats) -> Row:
    """Return the row of fitted amplitudes; `moved` is what each brings to each number."""
    metric, count = moved.T @ moved, max(int(moved.any(axis=1).sum()) // 3, 1)
    amplitudes = solved.amplitudes
    spread = Spread(float(solved.freedom), 2.0 * solved.freedom)
    return Row(
        quantity=title[0],
        unit=title[1],
        count=solved.freedom,
        chi2=solved.chi2,
        freedom=spread.mean,
        p_value=spread.p_value(solved.chi2),
        error=root_mean(solved.chi2, spread.mean),
        sampling=float(np.sqrt(0.5 / max(solved.freedom, 1))),
        size=1e3 * root_mean(float(amplitudes @ metric @ amplitudes), count),
        floor=1e3 * root_mean(float(np.trace(metric @ solved.covariance)), count),
    )
