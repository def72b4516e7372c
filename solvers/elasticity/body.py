"""The interfaces of a body in contact: its patch, how forces displace the patch's nodes, and the prints that forces
leave.

`placement.place` puts any such body into world axes; other code does not distinguish where it comes from. A meshed body
is condensed to its patch (`condensation.CondensedBody`); a body of known compliance matrix, from a file or a closed
form, is `CondensedBody.whole`; a class of its own may compute displacements on request, and yield.
"""

from typing import Protocol

from geometry import ContactPatch
from geometry.arrays import Array, IntArray
from solvers.elasticity.patch_compliance import Bricks


class Compliance(Protocol):
    """Displacements of the n nodes of a patch by forces on them, mm/N (for planar bodies mm per N/mm).

    Unknown 3 i + k belongs to node i and axis k. The matrix is symmetric and positive definite.
    """

    @property
    def rotation(self) -> Array:
        """Matrix (3, 3) that turns vectors from the body's axes into the axes of forces and displacements."""
        ...

    @property
    def dense(self) -> Array:
        """The whole matrix (3 n, 3 n)."""
        ...

    def between(self, moved: IntArray, loaded: IntArray, out: Array | None = None, add: Array | None = None) -> Array:
        """Displacements of the nodes `moved` (k,) by unit forces on the nodes `loaded` (l,): (3 k, 3 l).

        out: array to write them to, which is returned; None: a new one. add: (3,) factors on the components of force,
        with which the displacements are multiplied and then added to `out`; None: they replace what is in it.
        """
        ...

    def diagonal(self) -> Array:
        """Displacement of each unknown by a unit force on itself, (3 n,)."""
        ...

    def turned(self, rotation: Array) -> "Compliance":
        """The compliance in other axes; `rotation` (3, 3) turns vectors from the present axes into those."""
        ...


class ContactBody(Protocol):
    """A body in its own axes: its contact patch faces +z."""

    @property
    def patch(self) -> ContactPatch:
        """The nodes that may be loaded, and the unworn surface there."""
        ...

    @property
    def folded(self) -> Compliance:
        """Compliance of the patch's nodes relative to the grip, in the body's axes."""
        ...

    @property
    def bricks(self) -> Bricks | None:
        """The elements under the patch, to correct their errors near a loaded node; None if none are corrected."""
        ...

    @property
    def yields(self) -> bool:
        """True if forces can leave a print, a permanent depth."""
        ...

    def update(self, print_mm: Array, force_N: Array, /) -> Array:
        """Depth (n_a, n_t) in mm of the print after forces (n, 3) in N on the nodes, in the body's axes; print_mm: its
        depth before.
        """
        ...
