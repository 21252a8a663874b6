"""A collision laboratory as software: fire, film, measure, compare with the model.

In a notebook or a script, from a folder of frames to a plot::

    import rigctl

    campaign = rigctl.open("sample-shots")
    campaign.measure().table()
    fit = campaign.fit()
    fit.rank().plot()

Names load when they are used: the command line does not wait for them.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from analysis.arrays import Floats
    from analysis.collision.operator import Encounter, Operator, Outcome
    from analysis.effects.effect import (
        CameraEffect,
        ClockEffect,
        ContactEffect,
        Effect,
        Exposure,
        FlightEffect,
        Flying,
        Parameter,
        Values,
    )
    from analysis.quantity import Quantity
    from analysis.setup import CameraSetup
    from rigctl.api.campaign import Campaign
    from rigctl.api.comparison import Agreement, Structure
    from rigctl.api.fit import Fit
    from rigctl.api.opening import open_campaign as open
    from rigctl.api.own_effects import effects
    from rigctl.api.proposals import Proposals
    from rigctl.api.ranking import ErrorPath, Ranking
    from rigctl.api.shots import Shots
    from rigctl.api.verdict import Verdict
    from rigctl.errors import AnalysisInputError, NotFoundError, RigError

    __version__: str

_EFFECT, _OPERATOR = "analysis.effects.effect", "analysis.collision.operator"
_PLACES = {
    "Agreement": "rigctl.api.comparison",
    "AnalysisInputError": "rigctl.errors",
    "CameraEffect": _EFFECT,
    "CameraSetup": "analysis.setup",
    "Campaign": "rigctl.api.campaign",
    "ClockEffect": _EFFECT,
    "ContactEffect": _EFFECT,
    "Effect": _EFFECT,
    "Encounter": _OPERATOR,
    "ErrorPath": "rigctl.api.ranking",
    "Exposure": _EFFECT,
    "Fit": "rigctl.api.fit",
    "FlightEffect": _EFFECT,
    "Floats": _EFFECT,
    "Flying": _EFFECT,
    "NotFoundError": "rigctl.errors",
    "Operator": _OPERATOR,
    "Outcome": _OPERATOR,
    "Parameter": _EFFECT,
    "Proposals": "rigctl.api.proposals",
    "Quantity": "analysis.quantity",
    "Ranking": "rigctl.api.ranking",
    "RigError": "rigctl.errors",
    "Shots": "rigctl.api.shots",
    "Structure": "rigctl.api.comparison",
    "Values": _EFFECT,
    "Verdict": "rigctl.api.verdict",
    "effects": "rigctl.api.own_effects",
    "open": "rigctl.api.opening",
}
_OTHER_NAMES = {"open": "open_campaign"}

__all__ = [
    "Agreement",
    "AnalysisInputError",
    "CameraEffect",
    "CameraSetup",
    "Campaign",
    "ClockEffect",
    "ContactEffect",
    "Effect",
    "Encounter",
    "ErrorPath",
    "Exposure",
    "Fit",
    "FlightEffect",
    "Floats",
    "Flying",
    "NotFoundError",
    "Operator",
    "Outcome",
    "Parameter",
    "Proposals",
    "Quantity",
    "Ranking",
    "RigError",
    "Shots",
    "Structure",
    "Values",
    "Verdict",
    "__version__",
    "effects",
    "open",
]


def __getattr__(name: str) -> object:
    """Load the object of a public name."""
    if name == "__version__":
        from importlib.metadata import version  # noqa: PLC0415 - slow, and rarely needed

        value: object = version("rigctl")
    elif name in _PLACES:
        value = getattr(import_module(_PLACES[name]), _OTHER_NAMES.get(name, name))
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted(__all__)
