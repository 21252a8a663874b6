"""What a search concludes: the forms that went in, in order, and the fit with everything in."""

from __future__ import annotations

from dataclasses import dataclass

from analysis.collision.operator import Encounter
from analysis.model.data.evidence import Evidence, Stage
from analysis.model.data.stream import whole
from analysis.model.data.tables import Data
from analysis.model.fitting.fit import Fit
from analysis.model.predict.contact import encounter_of
from analysis.model.proposals.admissible import Admitted
from analysis.model.proposals.channels import Form
from analysis.model.proposals.launch_search import LaunchProposal
from analysis.model.proposals.refine import Refitted
from analysis.quantity import Quantity


@dataclass(frozen=True, slots=True, eq=False)
class Accepted:
    """One form that went in.

    Attributes
    ----------
    found
        The form with its constants, and its name in the fit.
    shapes
        Names of the shapes that these shots do not tell apart, the best first.
    alike, alike_effects
        Slots and arguments that they do not tell from it, and effects of the catalogue.
    p_familywise
        Of its score, when it was found.
    before, after
        The stages of the error path.
    freed
        The fit in which its constants are free: their errors.
    rival
        The best form of another slot or argument that these shots do not tell from it and others
        may: none that is an impulse where this is the coefficient that sets it.
    """

    found: Refitted
    shapes: tuple[str, ...]
    alike: tuple[tuple[str, str], ...]
    alike_effects: tuple[str, ...]
    p_familywise: float
    before: Stage
    after: Stage
    freed: Fit
    rival: Form | None = None

    @property
    def form(self) -> Form:
        """The form."""
        return self.found.form

    @property
    def name(self) -> str:
        """Of its effect in the fit."""
        return self.found.name

    @property
    def quantities(self) -> dict[str, Quantity]:
        """Amplitudes and constants by symbol, with their standard errors.

        Where a fit cannot follow a constant, as the place of a step between two shots, its value is
        the best that was tried.
        """
        own = f"{self.name}."
        found = {
            name.removeprefix(own): quantity
            for name, quantity in self.freed.parameters().items()
            if name.startswith(own)
        }
        scales = self.form.freed(self.name).parameters[len(self.form.symbols) :]
        values = self.form.constants[len(self.form.constants) - len(scales) :]
        held = zip(scales, values, self.found.scored.widths, strict=False)
        for scale, value, width in held:
            found.setdefault(scale.symbol, Quantity(float(value), width, scale.unit))
        return found


@dataclass(frozen=True, slots=True, eq=False)
class Proposed:
    """What is concluded.

    Attributes
    ----------
    accepted
        The forms, in the order in which they went in.
    effects
        Names of the catalogue's effects in the fit: those asked for, and those that went in.
    launch
        What the launches depend on, judged by themselves.
    """

    evidence: Evidence
    path: tuple[Stage, ...]
    accepted: tuple[Accepted, ...]
    effects: tuple[str, ...]
    admitted: Admitted
    launch: tuple[LaunchProposal, ...] = ()

    @property
    def fit(self) -> Fit:
        """The fit with everything in."""
        return self.path[-1].fit

    @property
    def data(self) -> Data:
        """What was fitted."""
        return whole(self.evidence.data)

    @property
    def encounter(self) -> Encounter:
        """How the spheres of every shot meet."""
        return encounter_of(self.data, self.fit.states, self.fit.theory)
