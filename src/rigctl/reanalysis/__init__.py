"""A whole campaign analysed once more, on all processors or on a cluster, results side by side."""

from rigctl.reanalysis.campaign import Outcome, reanalyse_campaign
from rigctl.reanalysis.comparing import Comparison, Comparisons
from rigctl.reanalysis.pools import Pool, pool

__all__ = ["Comparison", "Comparisons", "Outcome", "Pool", "pool", "reanalyse_campaign"]
