"""Configuration of a rig: strict models and the loader that names every mistake."""

from rigctl.config.actuators import (
    Alicat,
    Lcus,
    Magnet,
    SolenoidPair,
    TriggerBox,
    TriggerSection,
    Zaber,
)
from rigctl.config.camera import (
    CameraSection,
    ChronosCamera,
    EktaproCamera,
    EktaproLink,
    FilesSource,
    FilmCamera,
    FreeRateCamera,
    GenicamCamera,
    HidRelay,
    OwnCamera,
    PixelFormatName,
    RemoteTriggerSection,
    SerialLine,
    SourceSection,
    V4l2Camera,
    V4l2Source,
)
from rigctl.config.configuration import (
    AnalysisSection,
    Configuration,
    ServiceSection,
    Simulation,
    StoreSection,
)
from rigctl.config.limits import Limits
from rigctl.config.loading import default_path, faults_of, load, parse, read_toml
from rigctl.config.model import SIMULATED
from rigctl.config.scene import Optics

__all__ = [
    "SIMULATED",
    "Alicat",
    "AnalysisSection",
    "CameraSection",
    "ChronosCamera",
    "Configuration",
    "EktaproCamera",
    "EktaproLink",
    "FilesSource",
    "FilmCamera",
    "FreeRateCamera",
    "GenicamCamera",
    "HidRelay",
    "Lcus",
    "Limits",
    "Magnet",
    "Optics",
    "OwnCamera",
    "PixelFormatName",
    "RemoteTriggerSection",
    "SerialLine",
    "ServiceSection",
    "Simulation",
    "SolenoidPair",
    "SourceSection",
    "StoreSection",
    "TriggerBox",
    "TriggerSection",
    "V4l2Camera",
    "V4l2Source",
    "Zaber",
    "default_path",
    "faults_of",
    "load",
    "parse",
    "read_toml",
]
