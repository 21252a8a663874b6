"""What makes the flights of a film doubtful, or their e less sure than it might be: sentences."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from analysis.arrays import Floats
from analysis.balls.flight import path
from analysis.balls.flight.flights import LARGE_CHI2, Flights
from analysis.balls.flight.lost import MOST_SCATTER_PX
from analysis.balls.flight.suspects import MOST_E
from analysis.balls.gaps import period_of
from analysis.balls.measuring import MeasuredBall, coefficient
from analysis.quantity import Quantity

NOTED_CHI2 = 9.0
"""Mean square of the residuals in errors, from which on it is said."""
UNSURE_E = 1e-3
"""Change of e by frames that may be missing, from which on it is said."""
UNSETTLED_E = 0.01
"""Change of e when the ball's light is learned once more, of flights that do not fit the film."""
PUSHED = 0.1
"""Of the approach speed: what a ball may gain along a surface that is level, unsaid."""
MOST_BY_MASS, LEAST_BY_MASS = 0.7, 0.002
"""Of the error of e, and of e: what a mass that is not stated does, from which on it is said."""


def doubts(measured: MeasuredBall, flights: Flights, *, alone: bool = True) -> Iterator[str]:
    """Return the sentences on flights that are fitted; `alone`: off no other surface it bounces."""
    yield from _far_from_flights(flights)
    yield from _beyond_one(flights)
    yield from leaning(flights)
    yield from pushed_aside(flights)
    yield from _unsettled(measured.unsettled_e, flights)
    yield from _unsure(measured.unsure_e, flights)
    if measured.outline_e is not None:
        yield from _by_outline(measured.outline_e, flights)
    if measured.sizes_e is not None:
        yield from _by_sizes(measured.sizes_e, flights)
    yield from _by_mass(measured, flights)
    if measured.bounces == 1 and alone:
        yield from _alone(measured, flights)


def _by_mass(measured: MeasuredBall, flights: Flights) -> Iterator[str]:
    """Say that a mass would make e surer, where its error is the drag's of a ball of any mass."""
    if flights.weighed:
        return
    with_drag = flights.covariance[path.DRAG]
    sigma = math.sqrt(with_drag[path.DRAG])
    parts = [
        abs(float(flights.slopes_of_e(bounce) @ with_drag)) / sigma
        for bounce in range(flights.bounces)
    ]
    worst = int(np.argmax(parts))
    if parts[worst] > max(LEAST_BY_MASS, MOST_BY_MASS * coefficient(measured, worst)[1]):
        yield (
            f"the ball's mass is not stated, and with it how much the air slows it: e of bounce "
            f"{worst + 1} is uncertain by {parts[worst]:.4f} for that alone; state the mass "
            "(--ball-mass-g)"
        )


def _far_from_flights(flights: Flights) -> Iterator[str]:
    """Say how far places lie from flights that are no free ones."""
    row_rms = float(np.std(flights.residuals[flights.used, 0]))
    if row_rms > MOST_SCATTER_PX:
        far = f"scatter by {row_rms:.1f} px about free flights"
    elif flights.chi2_per_dof > LARGE_CHI2:
        times = flights.chi2_per_dof**0.5
        far = f"lie {times:.0f} times further from free flights than each is uncertain"
    else:
        if flights.chi2_per_dof > NOTED_CHI2:
            off = np.sqrt(np.mean(flights.residuals[flights.used] ** 2))
            yield (
                f"places scatter by {off:.2g} px about free flights, "
                f"{flights.chi2_per_dof**0.5:.0f} times as far as the light of each picture says: "
                "a codec, shading, seams or blotches move them; errors are as wide as the scatter"
            )
        return
    off = np.where(flights.used, np.hypot(*flights.residuals.T), 0.0)
    worst = int(np.argmax(off))
    row, column = flights.observed.places[worst]
    yield (
        f"places {far}, furthest in frame {flights.observed.frames[worst]} at ({row:.0f}, "
        f"{column:.0f}) px: check the frame rate; frames may be missing, the film's rate varies "
        "and its times do not say so, or something hides the ball; e may be further off than its "
        "error says"
    )


def leaning(flights: Flights) -> Iterator[str]:
    """Say how a plate leans that is not level, as several bounces show."""
    if flights.leans and flights.bounces > 1:
        size, sigma = math.degrees(abs(flights.lean)), math.degrees(flights.lean_sigma)
        lean = Quantity(size, sigma, "deg")
        yield (
            f"the surface leans by {lean.concise()} degrees, lower on the "
            f"{'right' if flights.lean > 0 else 'left'}; v_n, v_t and e are along its normal and "
            "beside it"
        )


def pushed_aside(flights: Flights) -> Iterator[str]:
    """Say where a ball leaves its plate sideways faster than it came: by spin, or as that leans."""
    if flights.leans and flights.bounces > 1:
        return
    for bounce, (_, came, beside, left, aside, _) in enumerate(flights.contacts.tolist()):
        gained = abs(aside) - abs(beside)
        if gained > PUSHED * came:
            lean = math.degrees(math.atan2(abs(aside - beside), came + left))
            scale = flights.scale_px_per_m
            yield (
                f"bounce {bounce + 1}, {_before(flights, bounce)}, leaves along the surface at "
                f"{abs(aside) / scale:.2f} m/s, faster than it came ({abs(beside) / scale:.2f}): "
                f"the ball spins, or the surface leans by some {lean:.0f} degrees; e takes it "
                "to lie as stated, else level or plumb, within 0.01 rad, and is off if it does not "
                "(spheres.normal in a campaign.toml, --setup)"
            )


def _beyond_one(flights: Flights) -> Iterator[str]:
    """Name bounces from which the ball comes faster than it went."""
    for bounce, e in enumerate((flights.contacts[:, 3] / flights.contacts[:, 1]).tolist()):
        if e > MOST_E:
            yield (
                f"e of bounce {bounce + 1}, {_before(flights, bounce)}, is {e:.2f}, and no ball "
                "leaves a plate at rest faster than it came: frames are missing, the film's rate "
                "varies and its times do not say so, or the plate moves; the error of e holds what "
                "is beyond 1"
            )


def _unsettled(unsettled_e: Floats, flights: Flights) -> Iterator[str]:
    """Name bounces whose e goes on changing as often as the film is fitted."""
    for bounce in np.flatnonzero(unsettled_e > UNSETTLED_E).tolist():
        yield (
            f"e of bounce {bounce + 1}, {_before(flights, bounce)}, still changes by "
            f"{unsettled_e[bounce]:.2f} each time that the film is fitted: the film's rate "
            "varies and its times do not say so, or something holds or hides the ball; the error "
            "of e holds as much"
        )


def _by_outline(outline_e: Floats, flights: Flights) -> Iterator[str]:
    """Name bounces whose e depends on where patches end that are as light as the ground."""
    for bounce in np.flatnonzero(outline_e > UNSETTLED_E).tolist():
        yield (
            f"e of bounce {bounce + 1}, {_before(flights, bounce)}, depends by "
            f"{outline_e[bounce]:.2f} on where the ball's outline is beside patches that are as "
            "light as what is behind them; the error of e holds as much"
        )


def _by_sizes(sizes_e: Floats, flights: Flights) -> Iterator[str]:
    """Name the bounce whose e depends most on the sizes of a ball whose mass is not stated."""
    bounce = int(np.argmax(sizes_e))
    if sizes_e[bounce] > UNSETTLED_E:
        yield (
            f"e of bounce {bounce + 1}, {_before(flights, bounce)}, depends by "
            f"{sizes_e[bounce]:.2f} on how large the ball is seen, which tells its drag from a "
            "drift towards the camera, and which a codec and smears change too; the error of e "
            "holds as much; state the mass (--ball-mass-g)"
        )


def _unsure(unsure_e: Floats, flights: Flights) -> Iterator[str]:
    """Name bounces whose e a time would change that seems to be missing."""
    for bounce in np.flatnonzero(unsure_e > UNSURE_E).tolist():
        yield (
            f"frames may be missing at bounce {bounce + 1}, {_before(flights, bounce)}, or in its "
            "flights, or the film's rate varies and its times do not say so; the error of its e "
            f"holds what that changes ({unsure_e[bounce]:.3f})"
        )


def _alone(measured: MeasuredBall, flights: Flights) -> Iterator[str]:
    """Say what one bounce alone leaves open: with later times the plate would only lie lower."""
    own = measured.head.times_s
    if own is not None and np.array_equal(own, measured.times_s):
        # The file has the time of each frame: one that is missing shows in them.
        return
    _, sigma = coefficient(measured, 0)
    each = flights.lost_at_first(period_of(measured.times_s))
    if each > sigma:
        yield (
            f"one bounce alone, {_before(flights, 0)}, does not show whether the film has all "
            f"frames of it: for each that it lacks there e is {each:.4f} too small, beyond its "
            "error; a second bounce would show it"
        )


def _before(flights: Flights, bounce: int) -> str:
    """Name the last frame before a bounce, and where the ball is in it."""
    last = int(np.flatnonzero(flights.arcs <= bounce)[-1])
    row, column = flights.observed.places[last]
    return f"after frame {flights.observed.frames[last]} at ({row:.0f}, {column:.0f}) px"
