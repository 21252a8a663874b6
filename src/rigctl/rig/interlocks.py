"""Named conditions that all must hold before anything may fire."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from rigctl.errors import InterlockError


@dataclass(frozen=True, slots=True)
class Interlock:
    """One condition as it was found.

    Attributes
    ----------
    name
        Stable name of the condition.
    holds
        Whether it allows a shot. A stale reading never does.
    value, limit, unit
        What was found, what is allowed, and the unit of both (empty for words).
    source
        The part that said so.
    read_at
        Monotonic time of the reading, s.
    todo
        What the operator does when it refuses.
    """

    name: str
    holds: bool
    value: float | str
    limit: str
    unit: str
    source: str
    read_at: float
    todo: str

    def age_s(self, now: float) -> float:
        """Return how long ago it was read, s."""
        return max(0.0, now - self.read_at)

    def sentence(self) -> str:
        """Return the condition as one line of text."""
        value = f"{self.value:.4g}" if isinstance(self.value, float) else self.value
        unit = f" {self.unit}" if self.unit else ""
        text = f"{self.name}: {value}{unit}, needed {self.limit}{unit} ({self.source})"
        return text if self.holds else f"{text}; {self.todo}"


def within(
    name: str,
    value: float,
    wanted: float,
    tolerance: float,
    *,
    unit: str,
    source: str,
    read_at: float,
    todo: str,
) -> Interlock:
    """Return a condition that holds while a reading is within its tolerance of what is wanted."""
    # A reading that is not a number compares false, and so refuses.
    holds = abs(value - wanted) <= tolerance
    limit = f"{wanted:g} ± {tolerance:g}"
    return Interlock(name, holds, value, limit, unit, source, read_at, todo)


def fresh(conditions: Iterable[Interlock], now: float, max_age_s: float) -> tuple[Interlock, ...]:
    """Return the conditions with every stale one tripped; a reading from the future is stale."""
    return tuple(_aged(condition, now, max_age_s) for condition in conditions)


def require(conditions: Iterable[Interlock], shot: str | None = None) -> None:
    """Let pass, or refuse with every condition that fails.

    Raises
    ------
    InterlockError
        At least one condition refuses; `tripped` has a sentence for each.
    """
    tripped = tuple(condition for condition in conditions if not condition.holds)
    if tripped:
        raise InterlockError(
            "; ".join(condition.sentence() for condition in tripped),
            tripped=tuple(condition.sentence() for condition in tripped),
            shot=shot,
        )


def _aged(condition: Interlock, now: float, max_age_s: float) -> Interlock:
    if 0 <= now - condition.read_at <= max_age_s:
        return condition
    return Interlock(
        condition.name,
        False,
        f"{condition.value} {condition.unit}".rstrip()
        + f", read {now - condition.read_at:.3g} s ago",
        f"a reading no older than {max_age_s:g} s",
        "",
        condition.source,
        condition.read_at,
        "check the device that gives this reading",
    )
