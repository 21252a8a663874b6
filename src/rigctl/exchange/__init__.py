"""Campaigns in and out of the catalogue, as exchange folders."""

from rigctl.exchange.contents import Contents, read_contents
from rigctl.exchange.exporting import Exported, export_campaign
from rigctl.exchange.importing import Imported, import_campaign

__all__ = [
    "Contents",
    "Exported",
    "Imported",
    "export_campaign",
    "import_campaign",
    "read_contents",
]
