"""How we look at flights: time plots, still pictures and 3D replays. The only room with matplotlib and meshcat.

Both are imported when something is drawn, not before.
"""

from uavlab.views.bank import plot_bank
from uavlab.views.picture import picture
from uavlab.views.plots import plot_compare, plot_flight, plot_heading, plot_path, save
from uavlab.views.qp import plot_qp
from uavlab.views.replay import Target, replay
from uavlab.views.reproduction import plot_outcome
from uavlab.views.show import Shown, show
from uavlab.views.sliders import sliders
from uavlab.views.story import has_modes
from uavlab.views.timeline import plot_story

__all__ = [
    "Shown",
    "Target",
    "has_modes",
    "picture",
    "plot_bank",
    "plot_compare",
    "plot_flight",
    "plot_heading",
    "plot_outcome",
    "plot_path",
    "plot_qp",
    "plot_story",
    "replay",
    "save",
    "show",
    "sliders",
]
