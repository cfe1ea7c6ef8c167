"""Real flights: fetched by name, checked by hash, told in our axes.

Cite whom `about(name).citation` names wherever the data is shown.
"""

from uavlab.datasets.catalogue import Dataset, about, names
from uavlab.datasets.phantom import DotImu, RtkTrack, read_dot, read_rtk
from uavlab.datasets.px4 import PX4Log, read_px4
from uavlab.datasets.record import as_log, read_flight
from uavlab.datasets.store import fetch

__all__ = [
    "Dataset",
    "DotImu",
    "PX4Log",
    "RtkTrack",
    "about",
    "as_log",
    "fetch",
    "names",
    "read_dot",
    "read_flight",
    "read_px4",
    "read_rtk",
]
