"""The catalogue once more, from what lies beside the shots."""

from rigctl.rebuilding.rebuild import Rebuilt, rebuild

__all__ = ["Rebuilt", "rebuild"]
