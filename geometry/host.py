"""The host of a block in a body from a file: the file's elements around the block, and the seam that joins both.

The block consists of hexahedra made by this program; see `embedded`.
"""

from dataclasses import dataclass

from geometry.arrays import Array, IntArray
from geometry.solid import Places, SolidMesh


@dataclass(frozen=True, eq=False)
class BlockSeam:
    """Where block and host are joined: f faces of the block's sides and back, with q integration points each."""

    cells: IntArray  #: (f,) cell of the block at each face.
    local: Array  #: (f, q, 3) integration points in the cells' reference coordinates.
    areas_mm2: Array  #: (f, q, 3) area of each point times the block's outward unit normal.
    depth_mm: Array  #: (f,) thickness of the block's cells at the faces.
    places: Places  #: Places of the f q points in the host.


@dataclass(frozen=True, eq=False)
class Host:
    """The elements of a file around a block, in the body's axes; n nodes and `size` cells."""

    solid: SolidMesh  #: All of the file's elements, those inside the block included.
    kept: Array  #: (size,) share of each cell, 0 to 1, that lies outside the block and counts.
    seam: BlockSeam
    held: IntArray  #: Indices of the host's nodes that the holder grips.
    areas_mm2: Array  #: (n,) area of the grip that belongs to each node of the host.
    part: IntArray  #: (size,) number of each cell's material in `parts`, from 1; 0 for the body's own.
    block_part: IntArray  #: (m, q) likewise, at the integration points of the block's cells.
    parts: tuple[tuple[float, float], ...]  #: (Young's modulus in MPa, Poisson's ratio) of each further material.
