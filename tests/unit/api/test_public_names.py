"""What `import rigctl` offers: these names, described, and nothing before it is wanted."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import rigctl

NAMES = {
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
    "Floats",
    "FlightEffect",
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
}
METHODS = {
    "Campaign": "agreement explain fit measure name propose propose_together",
    "Shots": "left_out name now plot table",
    "Fit": "add agreement campaign chi2_per_dof effects error_path parameters plot rank rejected "
    "structure table to_dict",
    "Proposals": "campaign confirm effects numbers plot sentences table to_dict verdict write",
    "Ranking": "best campaign p_familywise plot table to_list",
    "ErrorPath": "campaign errors plot table",
    "Agreement": "campaign plot prediction_error table to_dict",
    "Structure": "campaign plot plot_residuals table to_dict",
    "Verdict": "campaign doubts effects error_path next_shots numbers parameters plot ranking "
    "sentence table to_dict verdict",
}
"""Attributes that are set at the start are in these lists too; what is not here is not public."""


def test_the_public_names_are_these() -> None:
    assert sorted(rigctl.__all__) == sorted(NAMES) == dir(rigctl)


def test_the_names_that_load_late_are_those_that_a_type_checker_sees() -> None:
    tree = ast.parse(Path(rigctl.__file__).read_text(encoding="utf-8"))
    [checked] = [node for node in tree.body if isinstance(node, ast.If)]
    imports = [node for node in checked.body if isinstance(node, ast.ImportFrom)]
    seen = {
        name.asname or name.name: (node.module, name.name)
        for node in imports
        for name in node.names
    }
    assert set(seen) == NAMES - {"__version__"}
    for name, (module, inner) in seen.items():
        assert getattr(rigctl, name) is getattr(sys.modules[str(module)], inner), name


@pytest.mark.parametrize("name", sorted(NAMES - {"__version__", "Floats", "Operator", "Values"}))
def test_every_name_is_described(name: str) -> None:
    assert inspect.getdoc(getattr(rigctl, name))


@pytest.mark.parametrize("name", METHODS)
def test_the_methods_are_these_and_described(name: str) -> None:
    kind = getattr(rigctl, name)
    public = {one for one in dir(kind) if not one.startswith("_")}
    assert public <= set(METHODS[name].split())
    for one in public:
        assert inspect.getdoc(inspect.getattr_static(kind, one)), one


def test_an_unknown_name_is_refused_as_any_module_does() -> None:
    with pytest.raises(AttributeError, match="no attribute 'opne'"):
        rigctl.opne  # noqa: B018


def test_the_import_alone_loads_no_library() -> None:
    heavy = {"numpy", "scipy", "numba", "rich", "pydantic"}
    ask = f"import sys, rigctl; print({heavy} & {{*sys.modules}})"
    done = subprocess.run([sys.executable, "-c", ask], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"
