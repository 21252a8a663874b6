"""Campaigns in and out of the catalogue, as exchange folders.

Reading a folder loads the analysis, writing one does not: only functions that write are exported
here; the others are imported from `contents` and `importing`.
"""

from rigctl.exchange.exporting import Exported, export_campaign

__all__ = ["Exported", "export_campaign"]
