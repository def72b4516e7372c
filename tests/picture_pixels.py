"""What a written picture shows: the share of its pixels that have a colour of the house style."""

from pathlib import Path

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.image import imread

LEAST = 1e-4  #: A thin line of a few hundred pixels in a picture of a million.
PANELS = 0.84  #: Colour bars stand to the right of this share of the width.


def share_of(path: Path, colour: object, *, part: float = 1.0) -> float:
    """Share of the pixels in the left `part` of a picture whose red, green and blue are within 0.03 of a colour's."""
    pixels = imread(path)[..., :3]
    pixels = pixels[:, : int(part * pixels.shape[1])]
    near = np.abs(pixels - np.array(to_rgb(colour))).max(axis=-1) < 0.03  # type: ignore[arg-type]
    return float(near.mean())


def shows(path: Path, *colours: object, part: float = 1.0) -> bool:
    """Whether something is drawn in each of these colours."""
    return all(share_of(path, colour, part=part) > LEAST for colour in colours)
