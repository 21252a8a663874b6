"""Campaigns in and out of the catalogue, as exchange folders.

Reading a folder loads the analysis, writing one does not: only what writes is named here, and the
rest is taken from `contents` and `importing`.
"""

from rigctl.exchange.exporting import Exported, export_campaign

__all__ = ["Exported", "export_campaign"]
