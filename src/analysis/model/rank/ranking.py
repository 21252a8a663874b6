"""Which effects may be missing: all candidates scored in one pass.

Linearised around the fit, each shot's own numbers and the fitted parameters projected out, a
candidate has an expected drop in chi-squared of z^2 = g' M^-1 g and an amplitude M^-1 g, exact for
small effects. The score is a signpost; the verdict is the refit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Floats
from analysis.effects.clock.jitter_score import JitterScore
from analysis.effects.effect import ContactLaw, Effect, ScatterEffect
from analysis.model.data.stream import CampaignData
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.systematics import OF_IMAGES
from analysis.model.predict.theory import Theory
from analysis.model.rank.candidate import Candidate, Ranking, one_sided, weight_of
from analysis.model.rank.scatter import JitterTrial
from analysis.model.rank.score_test import Beside, Block, Sums, block_of, candidate_sums

_NAMES = frozenset(effect.name for effect in OF_IMAGES)


def with_places_moved(
    candidates: list[Candidate], data: CampaignData, theory: Theory, scale: float
) -> list[Candidate]:
    """Say of errors of images that are stated by how much they move places, and whether it counts.

    An outline's or a pattern's offset is stated with the slow errors of the images, and is in every
    fit as large as that. Freed of it, it follows whatever the images do along a flight: what moves
    the places of the spheres by no more than slow errors do is theirs, as in the heat map's cells.

    A fall is the sum of squares of what is moved over its standard error, so that root mean
    square, places weighted with their errors, at most sqrt(fall / sum of 1/sigma^2) is moved: the
    lines through the flights have a part in the fall, and no part in what moves beside them.

    Parameters
    ----------
    scale
        Root of chi-squared per degree of freedom, in which falls are counted.
    """
    stated = {s.effect.name for s in theory.systematics} & _NAMES
    if not stated or isinstance(data, ContactTable):
        return candidates
    weight = 0.0
    for part in data.parts():
        assert not isinstance(part, ContactTable)  # noqa: S101
        weight += float((part.position_sigma[np.isfinite(part.position_sigma)] ** -2).sum())
    limit = data.slow.between_m
    marked = []
    for one in candidates:
        moved = scale * float(np.sqrt(one.delta_chi2 / weight))
        known = one.seen and one.effect.name in stated
        marked.append(replace(one, moved_m=moved, of_measurement=moved < limit) if known else one)
    return marked


DRAWS = 2000
CARRIERS = 2
ONE_SIDED = 0.5
"""Share of chance campaigns in which a variance looks larger than nothing."""


def rank(data: CampaignData, fit: Fit, effects: Sequence[Effect], seed: int = 0) -> Ranking:
    """Score every effect that is not in the fit yet, each in all its variants.

    Parameters
    ----------
    seed
        Of the simulated scores behind `p_familywise`.
    """
    wanted, scatters = _free(fit.theory, _suitable(data, effects))
    trial = JitterTrial(data) if scatters and data.jitter_s == 0 else None
    scale = float(np.sqrt(max(fit.chi2_per_dof, 1e-12)))
    if not wanted and not scatters:
        return Ranking((), np.zeros((0, 0)), np.zeros((0, 0)), np.ones(DRAWS), scale, fit.freedom)
    shifts = _shifts((data, fit), wanted, scale, None if trial is None else trial.add)
    rng = np.random.default_rng(seed)
    smallest = smallest_by_chance(shifts.sums.matrix, shifts.blocks, shifts.weights, rng)
    chosen = [*shifts.candidates]
    if trial is not None:
        for effect in scatters:
            chosen.append(_scattered(trial.score(), effect))
            chance = rng.random(DRAWS)
            smallest = np.minimum(smallest, np.where(chance < ONE_SIDED, chance, 1.0))
    scored = [_with_familywise(c, smallest) for c in chosen]
    order = sorted(range(len(scored)), key=lambda k: (not scored[k].seen, -scored[k].delta_chi2))
    ranked = tuple(scored[k] for k in order)
    return Ranking(ranked, *_likeness(shifts, order), np.sort(smallest), scale, fit.freedom)


def _suitable(data: CampaignData, effects: Sequence[Effect]) -> list[Effect]:
    """Return the effects that make sense for the campaign's bodies."""
    plate = data.bodies[1].is_plate
    return [effect for effect in effects if not (effect.of_pairs and plate)]


def _free(theory: Theory, effects: Sequence[Effect]) -> tuple[list[Effect], list[ScatterEffect]]:
    """Return the effects that are not in the theory: those that shift poses, those of the noise."""
    present = {active.effect.name for active in theory.active}
    inside = {name for active in theory.active for name in active.effect.contains}
    free = [e for e in effects if e.name not in present | inside]
    scatters = [effect for effect in free if isinstance(effect, ScatterEffect)]
    return [effect for effect in free if not isinstance(effect, ScatterEffect)], scatters


@dataclass(frozen=True, slots=True, eq=False)
class _Shifts:
    """Effects that shift poses: blocks of all their variants, and each one's likeliest."""

    sums: Sums
    blocks: list[Block]
    weights: list[float]
    shown: list[Block]
    candidates: list[Candidate]


def _shifts(
    about: tuple[CampaignData, Fit], wanted: Sequence[Effect], scale: float, beside: Beside | None
) -> _Shifts:
    """Score effects in all their variants; p-values are of each by itself."""
    forms = [(k, form) for k, e in enumerate(wanted) for form in _forms(e)]
    data, fit = about
    sums = candidate_sums(data, fit, [form for _, form in forms], beside)
    blocks = _blocks(sums, [form for _, form in forms])
    falls = np.array([float(block.falls(sums.gradient)) for block in blocks]) / scale**2
    p_values = np.array([float(b.p_values(f)) for b, f in zip(blocks, falls, strict=True)])
    asked = {s.effect.name for s in fit.theory.systematics}
    weights = [weight_of(e, stated=e.name in asked) for e in (wanted[k] for k, _ in forms)]
    best = [
        min((i for i, (owner, _) in enumerate(forms) if owner == k), key=lambda i: p_values[i])
        for k in range(len(wanted))
    ]
    shown = [blocks[i] for i in best]
    candidates = [
        _candidate(
            sums,
            scale,
            effect=forms[i][1],
            block=blocks[i],
            delta_chi2=falls[i],
            p=p_values[i],
            carriers=tuple(int(n) for n in data.shots[list(places)]),
            share=share,
            of=wanted[forms[i][0]],
            weight=weights[i],
        )
        for i, (places, share) in zip(best, _carried(sums, shown), strict=True)
    ]
    candidates = with_places_moved(candidates, data, fit.theory, scale)
    return _Shifts(sums, blocks, weights, shown, candidates)


def _forms(effect: Effect) -> tuple[Effect, ...]:
    """Return what is scored of an effect: itself and its variants, or the shares of a law."""
    return effect.shares if isinstance(effect, ContactLaw) else (effect, *effect.variants)


def _likeness(shifts: _Shifts, order: Sequence[int]) -> tuple[Floats, Floats]:
    """Return aliases and imitated shares of candidates in an order, shifts before noise, (K, K)."""
    count = len(shifts.shown)
    shown = [shifts.shown[k] for k in order if k < count]
    among = np.array([place for place, k in enumerate(order) if k < count], dtype=np.intp)
    aliases, imitated = np.zeros((2, len(order), len(order)))
    aliases[np.ix_(among, among)] = alias_matrix(shifts.sums.matrix, shown)
    imitated[np.ix_(among, among)] = imitated_shares(shifts.sums, shown)
    return aliases, imitated


def _blocks(sums: Sums, forms: Sequence[Effect]) -> list[Block]:
    blocks, start = [], 0
    for form in forms:
        stop = start + len(form.parameters)
        blocks.append(block_of(sums, np.arange(start, stop), one_sided=one_sided(form)))
        start = stop
    return blocks


def _candidate(
    sums: Sums,
    scale: float,
    *,
    effect: Effect,
    block: Block,
    delta_chi2: float,
    p: float,
    carriers: tuple[int, ...],
    share: float,
    of: Effect,
    weight: float,
) -> Candidate:
    count = len(effect.parameters)
    seen = block.freedom > 0
    amplitudes, sigmas = np.full(count, np.nan), np.full(count, np.nan)
    if seen:
        amplitudes = block.amplitudes(sums.gradient)
        sigmas = scale * np.sqrt((block.whitening**2).sum(axis=1))
    return Candidate(
        effect=effect,
        delta_chi2=float(delta_chi2),
        freedom=block.freedom,
        amplitudes=amplitudes,
        sigmas=sigmas,
        p_value=float(p),
        p_familywise=1.0,
        seen=seen,
        carriers=carriers,
        carried_share=share,
        law=of if isinstance(of, ContactLaw) else None,
        weight=weight,
    )


def _scattered(score: JitterScore | None, effect: ScatterEffect) -> Candidate:
    return Candidate(
        effect=effect,
        delta_chi2=0.0 if score is None else score.delta_chi2,
        freedom=1,
        amplitudes=np.array([0.0 if score is None else score.amplitude]),
        sigmas=np.array([np.inf if score is None else score.sigma]),
        p_value=1.0 if score is None else score.p_delta_chi2,
        p_familywise=1.0,
        seen=score is not None,
        carriers=(),
        carried_share=0.0,
    )


def _carried(sums: Sums, blocks: Sequence[Block]) -> list[tuple[tuple[int, ...], float]]:
    """Return of each block the two shots with the largest part in its fall, and their share.

    The share is what of the fall goes with them; none of a block without a fall.
    """
    amplitudes = np.zeros((len(sums.gradient), len(blocks)))
    for k, block in enumerate(blocks):
        amplitudes[block.columns, k] = block.amplitudes(sums.gradient)
    carried: list[tuple[tuple[int, ...], float]] = []
    loud = sums.by_shot.loudest(amplitudes, CARRIERS)
    for block, whole, own in zip(blocks, sums.gradient @ amplitudes, loud, strict=True):
        if whole <= 0:
            carried.append(((), 0.0))
            continue
        rest = (sums.gradient - own.gradient)[block.columns] @ block.whitening
        carried.append((own.places, 1.0 - float((rest**2).sum()) / float(whole)))
    return carried


def _with_familywise(candidate: Candidate, smallest: Floats) -> Candidate:
    # The chance counts itself, so that a share of zero is never claimed.
    looked = candidate.p_value / candidate.weight
    share = (1 + int((smallest <= looked).sum())) / (1 + len(smallest))
    fields = {name: getattr(candidate, name) for name in candidate.__slots__}
    return Candidate(**{**fields, "p_familywise": share})


def smallest_by_chance(
    matrix: Floats, blocks: Sequence[Block], weights: Sequence[float], rng: np.random.Generator
) -> Floats:
    """Return the smallest p over weight of many campaigns with nothing missing, shape (draws,).

    Scores of such a campaign are Gaussian with the correlation of the columns. Columns are brought
    to unit length first: the rounding of the largest would be noise in those that are hardly felt.
    """
    size = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    unit = np.where(size > 0.0, size, 1.0)
    values, vectors = np.linalg.eigh(matrix / unit[:, None] / unit)
    root = size[:, None] * vectors * np.sqrt(np.clip(values, 0.0, None))
    draws = rng.standard_normal((DRAWS, len(matrix))) @ root.T
    # The smallest p of blocks that share a distribution is that of the largest fall.
    alike: dict[tuple[int, bool, float], list[Block]] = {}
    for block, weight in zip(blocks, weights, strict=True):
        alike.setdefault((block.freedom, block.one_sided, weight), []).append(block)
    least = [
        own[0].p_values(_largest_falls(draws, own)) / weight
        for (_, _, weight), own in alike.items()
    ]
    return np.asarray(np.min(least, axis=0))


def _largest_falls(draws: Floats, blocks: Sequence[Block]) -> Floats:
    """Return the largest fall of blocks of one distribution, for scores (draws, C)."""
    wide = [block for block in blocks if len(block.columns) > 1 or block.freedom == 0]
    single = [block for block in blocks if len(block.columns) == 1 and block.freedom == 1]
    largest = np.max([np.zeros(len(draws)), *(block.falls(draws) for block in wide)], axis=0)
    if single:
        columns = np.concatenate([block.columns for block in single])
        along = draws[:, columns] * np.concatenate([block.whitening[:, 0] for block in single])
        far = (along if single[0].one_sided else np.abs(along)).max(axis=1)
        largest = np.maximum(largest, np.square(np.maximum(far, 0.0)))
    return np.asarray(largest)


def alias_matrix(matrix: Floats, blocks: Sequence[Block]) -> Floats:
    """Return the largest canonical correlation between columns of any two candidates, (K, K)."""
    aliases = np.zeros((len(blocks), len(blocks)))
    ends = np.cumsum([0, *(block.freedom for block in blocks)])
    whole = _whitenings(len(matrix), blocks)
    cross = whole.T @ matrix @ whole
    freedom = np.diff(ends)
    single, wide = np.flatnonzero(freedom == 1), np.flatnonzero(freedom > 1)
    aliases[np.ix_(single, single)] = np.abs(cross[np.ix_(ends[single], ends[single])])
    for i in wide:
        rows = cross[ends[i] : ends[i + 1]]
        # With a single column the largest singular value is that column's length.
        aliases[i, single] = aliases[single, i] = np.linalg.norm(rows[:, ends[single]], axis=0)
        for j in wide:
            aliases[i, j] = np.linalg.norm(rows[:, ends[j] : ends[j + 1]], 2)
    return np.minimum(aliases, 1.0)


def imitated_shares(sums: Sums, blocks: Sequence[Block]) -> Floats:
    """Return the share of each candidate's fall that each other could bring, shape (K, K).

    Of what a candidate at its own amplitudes does to the residuals, as much as lies in the
    other's columns: 1 less the squared sine of the angle between them.
    """
    count = len(blocks)
    amplitudes = np.zeros((len(sums.matrix), count))
    for k, block in enumerate(blocks):
        amplitudes[block.columns, k] = block.amplitudes(sums.gradient)
    done = sums.matrix @ amplitudes
    whole = (amplitudes * done).sum(axis=0)
    along = _whitenings(len(done), blocks).T @ done
    owner = np.repeat(np.arange(count), [block.freedom for block in blocks])
    brought = np.zeros((count, count))
    np.add.at(brought, owner, along**2)
    shares = np.where(whole > 0, brought / np.where(whole > 0, whole, 1.0), 0.0)
    return np.asarray(np.minimum(shares, 1.0).T)


def _whitenings(size: int, blocks: Sequence[Block]) -> Floats:
    """Return the whitenings of all blocks beside each other, shape (C, directions seen)."""
    parts = []
    for block in blocks:
        part = np.zeros((size, block.freedom))
        part[block.columns] = block.whitening
        parts.append(part)
    return np.concatenate(parts, axis=1) if parts else np.zeros((size, 0))
