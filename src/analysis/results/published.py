"""What the thesis found for one-inch nylon spheres (section 7.2): values, without errors."""

from __future__ import annotations

from types import MappingProxyType

THESIS = MappingProxyType({"e": 0.74, "mu": 0.08, "beta0": 0.69})
"""Coefficients of the thesis by the names of the fit's parameters."""
