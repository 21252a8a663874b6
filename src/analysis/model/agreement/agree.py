"""A fit against its campaign, stage by stage."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from analysis import chi_squared
from analysis.model.agreement.freed import with_free_outcomes
from analysis.model.agreement.outcome import outcome_rows, outcomes
from analysis.model.agreement.poses import fitted_row, pose_groups, predicted_row, sides
from analysis.model.agreement.shapes import shape_rows
from analysis.model.agreement.table import Agreement, Row, Stage, looked_at_together
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import CampaignData, whole
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.noise import noise_scales
from analysis.model.rank.projector import Projector, projector
from analysis.model.structure.channels import (
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
    turn_sigma = np.repeat(data.rotation_sigma[..., None], 3, axis=-1)
    sigma = np.concatenate([data.position_sigma, turn_sigma], axis=-1)
    sigma = np.where(data.measured, sigma, 0.0).reshape(len(sigma), -1)
    free = with_free_outcomes(data, fit)
    unbound, states, theory = projector(free.data, free.fit), free.fit.states, free.fit.theory
    jumps, reach = contact_columns(free.data, states, theory), reach_of(free.data, free.fit)
    after = data.times_s > fit.states.time_s[:, None]
    known = (data.measured & ~after[..., None, None]).reshape(len(sigma), -1)
    before = sides(unbound, known).before
    split = sides(sums, known)
    fitted = [fitted_row(before, group, sigma) for group in pose_groups(data.measured, ~after)]
    poses = [predicted_row(split, group, sigma) for group in pose_groups(data.measured, after)]
    shapes = (
        Stage(name, tuple(shape_rows(free.data, unbound, groups, jumps=jumps, sigma=sigma)))
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
