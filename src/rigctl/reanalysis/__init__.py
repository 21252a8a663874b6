"""A whole campaign analysed once more, on all processors or on a cluster, results side by side."""

from rigctl.reanalysis.campaign import Outcome, reanalyse_campaign
from rigctl.reanalysis.comparing import Comparison, compared
from rigctl.reanalysis.pools import pool

__all__ = ["Comparison", "Outcome", "compared", "pool", "reanalyse_campaign"]
