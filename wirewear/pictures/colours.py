"""The colours of all pictures and pages; loading them takes no time, as loading what draws with them does."""

from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import Colormap, LinearSegmentedColormap

INK = "#1a1a1a"
GREY = "#8a8a8a"

#: Okabe and Ito's colour-blind safe palette, in the order in which variants take it.
VARIANT_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
VARIANT_DASHES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (1, 1)), (0, (6, 1.5, 1, 1.5)), (0, (3, 1)), (0, (8, 2)))

#: Depth: perceptually uniform, from the pale unworn surface to the dark bottom of the scar.
DEPTH_COLOURS: Colormap = LinearSegmentedColormap.from_list("depth", colormaps["magma_r"](np.linspace(0.02, 0.92, 256)))

#: Pressure and slip: uniform as well, and neither to be taken for a depth.
PRESSURE_COLOURS: Colormap = LinearSegmentedColormap.from_list(
    "pressure", colormaps["viridis_r"](np.linspace(0, 1, 256))
)
SLIP_COLOURS: Colormap = LinearSegmentedColormap.from_list("slip", colormaps["cividis_r"](np.linspace(0, 1, 256)))
