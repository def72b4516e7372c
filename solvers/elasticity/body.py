"""A body as a contact sees it, whatever it comes from: its patch, how that gives way, and what forces leave of it.

`placement.place` puts any of them into the world, and nobody else asks what stands behind. A meshed body is condensed
(`condensation.CondensedBody`); one whose matrix is known is `CondensedBody.whole`, be it from a file or a closed form;
a class of its own may work out displacements when they are asked for, and yield.
"""

from typing import Protocol

from geometry import ContactPatch
from geometry.arrays import Array, IntArray
from solvers.elasticity.patch_compliance import Bricks


class Compliance(Protocol):
    """How the n nodes of a patch move by forces on them, mm/N (of planar bodies mm per N/mm).

    Unknown 3 i + k belongs to node i and axis k. The matrix is symmetric and positive definite.
    """

    @property
    def rotation(self) -> Array:
        """The matrix (3, 3) that turns the body's axes into those of forces and displacements."""
        ...

    @property
    def dense(self) -> Array:
        """All of it, (3 n, 3 n)."""
        ...

    def between(self, moved: IntArray, loaded: IntArray, out: Array | None = None, add: Array | None = None) -> Array:
        """Displacements of some nodes (k,) by unit forces on others (l,), (3 k, 3 l), written to `out` if given.

        add: (3,) factors of the forces' components, with which the displacements are added to what `out` holds.
        """
        ...

    def diagonal(self) -> Array:
        """Displacement of each unknown by a unit force on itself, (3 n,)."""
        ...

    def turned(self, rotation: Array) -> "Compliance":
        """The compliance in other axes, by a matrix (3, 3) that turns vectors into them."""
        ...


class ContactBody(Protocol):
    """A body in its own axes, which faces +z."""

    @property
    def patch(self) -> ContactPatch:
        """The nodes through which it is loaded, and its unworn shape there."""
        ...

    @property
    def folded(self) -> Compliance:
        """How they give way, relative to the grip."""
        ...

    @property
    def bricks(self) -> Bricks | None:
        """The elements under the patch whose near field is to be made good; None where there is nothing to correct."""
        ...

    @property
    def yields(self) -> bool:
        """Whether forces leave a print."""
        ...

    def update(self, print_mm: Array, force_N: Array, /) -> Array:
        """Depth (n_a, n_t) in mm of the print after forces (n, 3) on the nodes. print_mm: the depth before them."""
        ...
