"""Campaigns in and out of the catalogue, as exchange folders.

Reading a folder (`contents`) loads the analysis, and so is not among the names given here.
"""

from rigctl.exchange.exporting import Exported, export_campaign
from rigctl.exchange.importing import Imported, import_campaign

__all__ = ["Exported", "Imported", "export_campaign", "import_campaign"]
