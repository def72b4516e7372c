"""The host of a block in a body from a file: the file's elements around the block, and the seam that joins both.

The block consists of hexahedra made by this program; see `embedded`.
"""

from dataclasses import dataclass

from geometry.arrays import Array, IntArray
from geometry.solid import Places, SolidMesh


@dataclass(frozen=True, eq=False)
class BlockSeam:
    """The seam, f faces of the block's sides and back with q integration points each, at which block and host are
    joined.
    """

    cells: IntArray  #: (f,) cell of the block at each face.
    local: Array  #: (f, q, 3) integration points in the reference element.
    areas_mm2: Array  #: (f, q, 3) area of each point times the block's outward normal.
    depth_mm: Array  #: (f,) thickness of the block's cells at the faces.
    places: Places  #: Places of the f q points in the host.


@dataclass(frozen=True, eq=False)
class Host:
    """The elements of a file around a block, in the body's axes; n nodes and `size` cells."""

    solid: SolidMesh
    kept: Array  #: Share of each cell (size,) that lies outside the block.
    seam: BlockSeam
    held: IntArray  #: Nodes of the host that the holder grips.
    areas_mm2: Array  #: (n,) area of the grip that belongs to each node of the host.
    part: IntArray  #: Of each cell (size,), the number of its material in `parts` from 1, 0 where it is the body's own.
    #: Numbers of materials at the integration points of the block's cells, (m, q), as in `part`.
    block_part: IntArray
    parts: tuple[tuple[float, float], ...]  #: Young's moduli in MPa and Poisson's ratios.
