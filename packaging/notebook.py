"""The Python interface of an installed wheel: shots are filmed in simulation, measured and fitted.

Run on systems where the daemon does not run.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import rigctl
from simulators.world import write_campaign

with TemporaryDirectory() as place:
    folder = Path(place) / "filmed"
    write_campaign(folder, [30.0, 45.0, 60.0, 75.0], [4.0, 8.0, 12.0, 16.0], 3)
    shots = rigctl.open(folder).measure(workers=2)
    fit = rigctl.open(folder).fit()
    fit.rank().plot().figure.savefig(Path(place) / "ranking.png")
    e = fit.parameters["e"]
    print(f"{shots}: e = {e.concise()}")  # noqa: T201
    if len(shots) != 4 or abs(e.value - 0.74) > max(0.005, 5 * e.sigma):
        raise SystemExit("that is not what was filmed")
