"""All forms scored in one pass, and how large the largest score is by chance.

z = U'r / s, with everything that is fitted projected out of U. Where nothing is missing the scores
are Gaussian with the correlation of the columns, so the quantile of max |z| over draws from it is
an exact family-wise threshold.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Protocol, TypeVar

import numpy as np
from scipy.special import erfc

from analysis.arrays import Floats
from analysis.model.proposals.arguments import Argument
from analysis.model.proposals.channels import Channels, Form, Sums
from analysis.model.proposals.forms.form import ContactForm
from analysis.model.proposals.forms.impulses import IMPULSES, TORSION
from analysis.model.proposals.forms.shapes import (
    FOR_COLUMNS,
    FOR_PLACES,
    FOR_SIGNED,
    FOR_SIZES,
    FOR_SPEEDS,
    LINEAR,
    POWER,
    Shape,
    Spread,
    spread_of,
)

DRAWS, RIDGE = 2000, 1e-7
FULL_SLOTS = ("e", "mu")
SPARE_SLOTS = ("beta0", TORSION, *IMPULSES)
"""Few shots tell of these: of shapes only the simplest are looked for."""
SMALLEST_P = 1e-300
_TAIL = 0.02
"""Chance below which a p-value is read off the normal's own tail, not off the few draws there."""


class Grouped(Protocol):
    """A form as scores see it: what depends on what, and its amplitudes."""

    @property
    def group(self) -> tuple[str, str]:
        """Slot and argument."""

    @property
    def symbols(self) -> tuple[str, ...]:
        """Of the amplitudes."""


@dataclass(frozen=True, slots=True, eq=False)
class Screen:
    """Scores of K columns.

    Attributes
    ----------
    columns
        The form and the number of its column.
    scores
        z, shape (K,).
    largest
        max |z| of campaigns with nothing missing, sorted, shape (draws,).
    blocks
        Root of the fall of forms of several amplitudes, less what all but one bring by chance.
    """

    columns: tuple[tuple[Grouped, int], ...]
    scores: Floats
    largest: Floats
    blocks: tuple[tuple[Grouped, float], ...] = ()

    def threshold(self, level: float) -> float:
        """Return |z| above which a share `level` of campaigns with nothing missing has one."""
        return float(np.quantile(self.largest, 1.0 - level)) if self.largest.size else np.inf

    def p_familywise(self, score: float) -> float:
        """Return the chance of a largest |z| like this in a campaign with nothing missing."""
        if not self.largest.size:
            return 1.0
        above = 1 + int((self.largest >= abs(score)).sum())
        if above > _TAIL * (1 + len(self.largest)):
            return above / (1 + len(self.largest))
        looks = _TAIL / float(erfc(self.threshold(_TAIL) / np.sqrt(2)))
        return float(np.clip(looks * erfc(abs(score) / np.sqrt(2)), SMALLEST_P, _TAIL))

    def groups(self) -> dict[tuple[str, str], float]:
        """Return the largest |z| of each slot and argument, the largest first."""
        singles = zip(self.columns, np.abs(self.scores), strict=True)
        return _largest([(form, float(score)) for (form, _), score in singles])

    def near(self, within: float) -> list[tuple[str, str]]:
        """Return the groups whose fall is so near to the largest, all amplitudes of a form in."""
        singles = zip(self.columns, np.abs(self.scores), strict=True)
        found = _largest([*((f, float(z)) for (f, _), z in singles), *self.blocks])
        best = max(found.values(), default=0.0)
        return [group for group, z in found.items() if z**2 > best**2 - within]


AForm = TypeVar("AForm", bound=Grouped)


def screened(
    channels: Channels, forms: Sequence[Form], rng: np.random.Generator, sums: Sums | None = None
) -> Screen:
    """Score the columns of all forms; those that cannot be seen are left out.

    Parameters
    ----------
    sums
        M and g of these columns, where they are known already: of several campaigns together.
    """
    columns = columns_of(forms)
    if not columns:
        return Screen((), np.zeros(0), np.zeros(0))
    if sums is None:
        sums = channels.summed([channels.weights(form, number) for form, number in columns])
    return scored(columns, sums, channels.noise_scale, rng)


def scored(
    columns: Sequence[tuple[Grouped, int]],
    sums: Sums,
    noise_scale: float,
    rng: np.random.Generator,
) -> Screen:
    """Score columns whose sums are known; those that cannot be seen are left out."""
    seen = sums.seen
    kept = sums.of(seen)
    root = np.sqrt(np.diag(kept.matrix))
    scores = kept.gradient / root / noise_scale
    correlation = kept.matrix / root[:, None] / root[None, :]
    left = tuple(column for column, own in zip(columns, seen, strict=True) if own)
    largest = np.sort(largest_by_chance(correlation, rng))
    return Screen(left, scores, largest, _blocks(left, kept, noise_scale))


def _largest(scored: Sequence[tuple[Grouped, float]]) -> dict[tuple[str, str], float]:
    found: dict[tuple[str, str], float] = {}
    for form, score in scored:
        found[form.group] = max(found.get(form.group, 0.0), score)
    return dict(sorted(found.items(), key=lambda entry: -entry[1]))


def _blocks(
    kept: Sequence[tuple[Grouped, int]], sums: Sums, noise_scale: float
) -> tuple[tuple[Grouped, float], ...]:
    """Return what forms of several amplitudes bring together."""
    places: dict[int, list[int]] = {}
    forms: dict[int, Grouped] = {}
    for k, (form, _) in enumerate(kept):
        if len(form.symbols) > 1:
            places.setdefault(id(form), []).append(k)
            forms[id(form)] = form
    found = []
    for key, rows in places.items():
        block = sums.of(np.array(rows))
        delta_chi2 = block.gradient @ np.linalg.lstsq(block.matrix, block.gradient, rcond=1e-10)[0]
        beyond = float(delta_chi2) / noise_scale**2 - (len(rows) - 1)
        found.append((forms[key], float(np.sqrt(max(beyond, 0.0)))))
    return tuple(found)


def columns_of(forms: Sequence[AForm]) -> list[tuple[AForm, int]]:
    """Return every column of every form."""
    return [(form, number) for form in forms for number in range(len(form.symbols))]


def largest_by_chance(correlation: Floats, rng: np.random.Generator) -> Floats:
    """Return max |z| of draws of Gaussian scores with a correlation (K, K), shape (draws,)."""
    size = len(correlation)
    if size == 0:
        return np.zeros(0)
    ridged = correlation.copy()
    ridged[np.arange(size), np.arange(size)] = 1.0 + RIDGE * size
    try:
        root = np.linalg.cholesky(ridged)
    except np.linalg.LinAlgError:
        values, vectors = np.linalg.eigh(correlation)
        root = vectors * np.sqrt(np.clip(values, 0.0, None))
    draws = root.astype(np.float32) @ rng.standard_normal((size, DRAWS), dtype=np.float32)
    return np.asarray(np.abs(draws).max(axis=0), dtype=np.float64)


Spreads = Mapping[tuple[str, str], Spread]
"""Where shots lie in every argument that is one number, by its key."""


def spreads_of(channels: Channels, arguments: Sequence[Argument]) -> Spreads:
    """Return where the shots of a campaign lie."""
    encounter = channels.encounter
    return {a.key: spread_of(a.of(encounter)[:, 0]) for a in arguments if a.is_scalar}


def contact_forms(
    channels: Channels, arguments: Sequence[Argument], spreads: Spreads | None = None
) -> list[ContactForm]:
    """Return every slot with every argument in every shape, and products of two arguments.

    Parameters
    ----------
    spreads
        Which set the constants that are tried; None: those of the campaign.
    """
    spreads = spreads_of(channels, arguments) if spreads is None else spreads
    found = []
    for slot in (*FULL_SLOTS, *SPARE_SLOTS):
        for argument in arguments:
            found += _with_argument(channels, slot, argument, spreads)
    products = [a for a in arguments if a.is_scalar and a.symbol != "|w_n|" and not a.is_setting]
    for slot in FULL_SLOTS:
        for pair in combinations(products, 2):
            zeros = spreads[pair[0].key].mean, spreads[pair[1].key].mean
            found.append(_reaching(channels, ContactForm(slot, pair, None, zeros, (1.0,))))
    return found


def _with_argument(
    channels: Channels, slot: str, argument: Argument, spreads: Spreads
) -> list[ContactForm]:
    if not argument.is_scalar:
        none = ContactForm(slot, (argument,), None, (), (1.0,) * len(argument.codes))
        return [_reaching(channels, none)]
    shapes = shapes_of(argument) if slot in FULL_SLOTS else _simplest(argument)
    spread = spreads[argument.key]
    return [f for shape in shapes for f in shaped(channels, slot, argument, shape, spread)]


def shaped(
    channels: Channels,
    slot: str,
    argument: Argument,
    shape: Shape,
    spread: Spread,
    *,
    fine: int = 1,
) -> list[ContactForm]:
    """Return a shape with the constants of its grid; `fine` > 1: of a finer one."""
    ones = (1.0,) * len(shape.codes)
    return [
        _reaching(channels, ContactForm(slot, (argument,), shape, constants, ones))
        for constants in shape.grid(spread, fine)
    ]


def shapes_of(argument: Argument) -> tuple[Shape, ...]:
    """Return the shapes that a dependence on an argument may have."""
    if argument.name in {"speed_n", "speed_s", "obliquity"}:
        return FOR_SPEEDS
    if argument.name == "spin":
        return FOR_SIZES if argument.symbol.startswith("|") else FOR_SIGNED
    return FOR_PLACES if argument.name.startswith("contact") else FOR_COLUMNS


def _simplest(argument: Argument) -> tuple[Shape, ...]:
    return (LINEAR, POWER) if argument.positive else (LINEAR,)


def _reaching(channels: Channels, form: ContactForm) -> ContactForm:
    """Return a form that knows how large its columns are over the shots."""
    largest = np.abs(form.columns(channels.encounter)).max(axis=0)
    return ContactForm(
        form.slot, form.arguments, form.shape, form.constants, tuple(map(float, largest))
    )
