"""Makes the tables of spring_slider: python -m analysis.effects.contact.spring_slider_tables."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from analysis.effects.contact.spring_slider import TABLES, Pressing, integrated, table_name
from analysis.effects.contact.tangential_compliance import LAWS

LEVER = 3.5
"""1 + 1/K of a solid sphere."""
RESTITUTIONS = np.arange(0.3, 1.001, 0.05)
SPACING = 0.05
"""Of the tables in chi."""


def required_tables() -> list[tuple[Pressing, float, float]]:
    """Return law, chi and e of every table that a solid sphere needs."""
    found = []
    for ratio, pressing in LAWS:
        column = ratio * LEVER / 2 / SPACING
        for k in sorted({int(np.floor(column + 1e-9)), int(np.ceil(column - 1e-9))}):
            found += [(pressing, SPACING * k, round(float(e), 2)) for e in RESTITUTIONS]
    return found


def main() -> None:
    """Write the tables beside this file."""
    tables = {
        table_name(pressing, chi, e): integrated(pressing, chi, e).astype(np.float32)
        for pressing, chi, e in required_tables()
    }
    np.savez_compressed(Path(__file__).with_name(TABLES), allow_pickle=False, **tables)


if __name__ == "__main__":
    main()
