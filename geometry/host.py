"""What surrounds a block of our own elements in a body from a file: the file's elements, and how both hang together."""

from dataclasses import dataclass

from geometry.arrays import Array, IntArray
from geometry.solid import Places, SolidMesh


@dataclass(frozen=True, eq=False)
class BlockSeam:
    """Points of the block's sides and back at which it hangs on the host: f faces of q points each."""

    cells: IntArray  #: (f,) of the block.
    local: Array  #: (f, q, 3) in the reference element.
    areas_mm2: Array  #: (f, q, 3) along the block's outward normal.
    depth_mm: Array  #: (f,) of the cells below the faces.
    places: Places  #: Of the f q points in the host.


@dataclass(frozen=True, eq=False)
class Host:
    """The elements of a file about a block, in the body's axes."""

    solid: SolidMesh
    kept: Array  #: Share of each cell (size,) that lies outside the block.
    seam: BlockSeam
    held: IntArray  #: Nodes of the file's that the holder grips.
    areas_mm2: Array  #: (n,) of the grip that belong to the file's nodes.
    part: IntArray  #: Of each cell (size,), the number of its material in `parts` from 1, 0 where it is the body's own.
    block_part: IntArray  #: The same of the block's cells.
    parts: tuple[tuple[float, float], ...]  #: Young's moduli in MPa and Poisson's ratios.
