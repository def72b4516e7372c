"""Displacements of whole bodies: by forces on a contact patch, and of two planar bodies that stick together.

The same stiffness, grip and symmetry as in `elasticity.condensation`, so the patch moves as its compliance says. Forces
are taken apart into parts even and odd about each mirror plane. Each has a factor of the piece on one side, made when
the first such force comes. What is far from wear is eliminated once for all states of a body.

Of bodies that stick: when the motion turns round, no point of the contact slips at first (Mindlin & Deresiewicz, J.
Appl. Mech. 20 (1953) 327). For a small step the contact is then a joint over the width that carries load, and the
problem is linear.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

import numpy as np
from scipy.sparse import csr_matrix
from threadpoolctl import threadpool_limits

from geometry import Elastic, HexMesh, QuadMesh, mirror_images
from geometry.arrays import Array, BoolArray, IntArray
from solvers.elasticity import condensation
from solvers.elasticity.elimination import unknowns_of
from solvers.elasticity.embedding import Joined
from solvers.elasticity.linear_elasticity import TENSOR_PLACES, Projection, solved_for_mass, stiffness_matrix
from solvers.stress.factors import Factor, Far, factorised

#: A contact is solved less exactly: forces of a symmetry below this share of the largest are none, and states whose
#: forces differ by no more are one state.
_ALIKE = 1e-9

_FEW = 3  #: For fewer states than this, conjugate gradients project faster than factors that are still to be made.


@dataclass(frozen=True, eq=False)
class CycleImage:
    """A mirror that takes a body onto itself and states of its cycle into others; it may be the identity, without a
    mirror.

    For example the second half of a stroke to and fro is the image of the first.
    """

    sides: Array  #: (3,) -1 for axes about whose zero it mirrors, else 1.
    node: IntArray  #: (n,) node onto which each is mapped.
    source: IntArray  #: (s,) index of the earlier state of which each state is the image; its own if there is none.

    @cached_property
    def computed(self) -> IntArray:
        """(c,) indices of the states that are not images of earlier ones, and so must be computed."""
        return np.flatnonzero(self.source == np.arange(len(self.source)))

    def with_images(self, points_mm: Array) -> tuple[Array, IntArray]:
        """The points (k, 2) in mm followed by their mirror images, and the index in that list of each entry's own
        image, (2 k,); the points alone, each its own image, if `sides` mirrors nothing.
        """
        count = np.arange(len(points_mm))
        if np.all(self.sides > 0.0):
            return points_mm, count
        return np.vstack([points_mm, points_mm * self.sides[:2]]), np.concatenate([len(count) + count, count])

    def moved(self, displacement: Array) -> Array:
        """Displacements (s, n, 3) of all states, from those (c, n, 3) of the computed ones."""
        found: Array = displacement[np.searchsorted(self.computed, self.source)]
        others = self.source != np.arange(len(self.source))
        found[others] = found[others][:, self.node] * self.sides
        return found

    def completed(self, stress: Array, image: IntArray) -> Array:
        """Stresses (s, k, 6) of all states, from those (c, k, 6) of the computed ones, at points of which `image` (k,)
        is the index of the mirror image.
        """
        found: Array = stress[np.searchsorted(self.computed, self.source)]
        others = self.source != np.arange(len(self.source))
        found[others] = found[others][:, image] * [self.sides[i] * self.sides[j] for i, j in TENSOR_PLACES]
        return found


@dataclass
class Shared:
    """What bodies share that differ in wear: unknowns that are eliminated by what they are of, and by mirror planes the
    projection in elements that do not differ.
    """

    eliminated: dict[tuple[object, ...], Far] = field(default_factory=dict)
    projections: dict[tuple[int, ...], Projection] = field(default_factory=dict)


@dataclass
class Interior:
    """A body with nodes that are held, solved for the displacements of all n nodes by forces on some. Factors are kept
    once made.
    """

    mesh: HexMesh | QuadMesh
    material: Elastic
    held: IntArray  #: Indices of nodes that do not move.
    #: (n,) stiffness in N/mm (planar: per mm) that holds nodes elastically in all directions; 0 at most. None: none is.
    bedding: Array | None = None
    #: (n,) nodes that stand elsewhere in other bodies, alike else, with which `shared` is; None: all.
    moving: BoolArray | None = None
    shared: Shared = field(default_factory=Shared, repr=False)

    def __post_init__(self) -> None:
        axes = (0,) if isinstance(self.mesh, QuadMesh) else (0, 1)
        images = {axis: self._image(axis) for axis in axes}
        self._images = {axis: image for axis, image in images.items() if image is not None}
        self._piece, self._number = condensation.one_side(self.mesh, self.planes)
        self._nodes = np.flatnonzero(self._number >= 0)[np.argsort(self._number[self._number >= 0])]
        #: For each node of the body the one of the piece whose image it is.
        self._own = self._number.copy()
        for image in self._images.values():
            self._own = np.where(self._own < 0, self._own[image], self._own)
        self._on_planes = sum(
            ((self._piece.points[:, axis] == 0.0).astype(int) for axis in self.planes), np.zeros(len(self._nodes), int)
        )
        self._factors: dict[tuple[object, ...], Factor] = {}
        cells = self._piece.cells
        near = np.ones(len(cells), bool) if self.moving is None else self.moving[self._nodes][cells].any(axis=1)
        #: Elements that differ between bodies, and the others if there are any.
        self._elements = [self._elements_of(cells[one]) for one in (near, ~near) if one.any()]
        self._differs = np.isin(np.arange(len(self._nodes)), cells[near])

    @property
    def planes(self) -> tuple[int, ...]:
        """Axes (0: x, 1: y) about whose zero the body, with what holds it, is its own mirror image."""
        return tuple(self._images)

    def displacements(self, nodes: IntArray, forces: Array) -> Array:
        """Displacements (s, n, 3) in mm of all nodes in s states, by forces (s, k, 3) in N on nodes of index (k,)."""
        image = self.cycle_image(nodes, forces, np.zeros((len(forces), 0)))
        return image.moved(self._computed(nodes, forces[image.computed]))

    def _computed(self, nodes: IntArray, forces: Array) -> Array:
        """What `displacements` gives, for states of which none is the image of another."""
        loaded = np.unique(nodes)
        for image in self._images.values():
            loaded = np.union1d(loaded, image[loaded])
        near = np.zeros((len(forces), len(loaded), 3))
        near[:, np.searchsorted(loaded, nodes)] = forces
        own = self._number[loaded]
        result = np.zeros((len(forces), len(self.mesh.points), 3))
        parts, at = {}, loaded[own >= 0]
        for odd, part in self._parts(lambda of: near[:, np.searchsorted(loaded, of)], at, self.planes).items():
            if np.abs(part).max() > _ALIKE * np.abs(forces).max():
                parts[odd] = np.zeros((len(forces), len(self._nodes), 3))
                parts[odd][:, own[own >= 0]] = part
        with threadpool_limits(limits=1, user_api="blas"):
            for odd, part in parts.items():
                # Nodes on a plane carry its half of their forces.
                half = part / 2.0 ** self._on_planes[None, :, None]
                moved = self._stiff(odd, parts).solved(half.reshape(len(half), -1).T)
                self._spread(result, moved.T.reshape(part.shape), odd)
        return result

    def stresses(self, displacements: Array, nodes: IntArray) -> Array:
        """Stresses (s, k, 6) in MPa at nodes (k,), by displacements (s, n, 3) in mm of all nodes. They are projected to
        the nodes: least squares of what they differ by from those inside the elements.
        """
        every = self._ways
        result = np.zeros((len(displacements), len(nodes), 6))
        # Loads of all motions, by the planes on which their stresses are zero.
        gathered: dict[tuple[bool, ...], list[tuple[BoolArray, Array, Array]]] = {}
        for odd, part in self._parts(lambda of: displacements[:, of], self._nodes, self.planes).items():
            if np.abs(part).max() <= _ALIKE * np.abs(displacements).max():
                continue
            loads = np.zeros((len(self._nodes), len(part), 6))
            for (_, of_part), projection in zip(self._elements, self._projections, strict=True):
                loads[of_part] += projection.loads(self.material, part[:, of_part])
            # Of each component its sign in the mirror image about each plane, on which it is zero where that is -1.
            signs = [
                np.array([(-1.0 if is_odd else 1.0) * side[i] * side[j] for i, j in TENSOR_PLACES])
                for side, is_odd in zip(map(_signs, self.planes), odd, strict=True)
            ]
            images = np.ones((len(nodes), 6))
            for axis, sign in zip(self.planes, signs, strict=True):
                images[self.mesh.points[nodes, axis] < 0.0] *= sign
            for zero in every:
                like = np.ones(6, dtype=bool)
                for sign, is_zero in zip(signs, zero, strict=True):
                    like &= (sign < 0.0) == is_zero
                gathered.setdefault(zero, []).append((like, images, loads[..., like].reshape(len(loads), -1)))
        each_loads = [np.hstack([one for _, _, one in each]) for each in gathered.values()]
        if len(displacements) >= _FEW or ("mass", *every[0]) in self._factors:
            solved = [self._mass(zero).solved(load) for zero, load in zip(gathered, each_loads, strict=True)]
        else:
            held, mass = [self._zero_on[every.index(zero)] for zero in gathered], sum(self._masses)
            solved = [_projected(mass, *one) for one in zip(held, each_loads, strict=True)]
        own = self._own[nodes]
        for each, found in zip(gathered.values(), solved, strict=True):
            parts = np.split(found[own], np.cumsum([one.shape[1] for _, _, one in each])[:-1], axis=1)
            for (like, images, _), part in zip(each, parts, strict=True):
                of_states = part.reshape(len(nodes), len(displacements), -1)
                result[..., like] += images[:, like] * np.swapaxes(of_states, 0, 1)
        return result

    @cached_property
    def _projections(self) -> list[Projection]:
        """The projection of stresses in the parts of the piece."""
        (near, _), *far = self._elements
        if far and self.planes not in self.shared.projections:
            self.shared.projections[self.planes] = Projection.of(far[0][0])
        return [Projection.of(near), *([self.shared.projections[self.planes]] if far else [])]

    @cached_property
    def _masses(self) -> list[csr_matrix]:
        """What the parts of the piece add to the matrix (p, p) of the projection."""
        both = zip(self._elements, self._projections, strict=True)
        return [self._widened(projection.mass, nodes) for (_, nodes), projection in both]

    def _elements_of(self, cells: IntArray) -> tuple[HexMesh | QuadMesh, IntArray]:
        """The mesh of these cells (m, c) of the piece, and its nodes' numbers (k,) in the piece."""
        nodes = np.unique(cells)
        return replace(self._piece, points=self._piece.points[nodes], cells=np.searchsorted(nodes, cells)), nodes

    def _widened(self, matrix: csr_matrix, nodes: IntArray) -> csr_matrix:
        """The matrix (d k, d k) of some nodes (k,) of the piece as one of all its nodes."""
        d, known = matrix.shape[0] // len(nodes), matrix.tocoo()
        place, size = unknowns_of(nodes, d), d * len(self._nodes)
        return csr_matrix((known.data, (place[known.row], place[known.col])), shape=(size, size))

    @property
    def _ways(self) -> list[tuple[bool, ...]]:
        """Ways of a field to be odd (True) or even about each plane."""
        return list(product((False, True), repeat=len(self.planes)))

    @cached_property
    def _zero_on(self) -> BoolArray:
        """(v, p) for each way the nodes of the piece on planes about which a field is odd, and so zero."""
        on_planes = np.array([self._piece.points[:, axis] == 0.0 for axis in self.planes]).reshape(-1, len(self._nodes))
        return np.array([on_planes[list(way)].any(axis=0) for way in self._ways])

    def _mass(self, zero: tuple[bool, ...]) -> Factor:
        """The factor by which stresses are projected in the piece that are zero on these planes."""
        near, *far = self._masses
        free = np.arange(len(self._nodes))
        return self._factor("mass", zero, self._ways, lambda: near, lambda: far, (free, 1, self._zero_on))

    def _factor(
        self,
        name: str,
        way: tuple[bool, ...],
        ways: Sequence[tuple[bool, ...]],
        near: Callable[[], csr_matrix],
        far: Callable[[], list[csr_matrix]],
        of: tuple[IntArray, int, BoolArray],
    ) -> Factor:
        """The factor for one of some ways to hold unknowns, which are made together, of the sum of two matrices: near
        what differs between bodies, and far from it, of none or one. of: nodes that are free, unknowns of each node,
        and those held in each way.
        """
        if (name, *way) not in self._factors:
            key, (free, d, held) = (name, self.planes, *ways), of
            if key not in self.shared.eliminated:
                none = csr_matrix((held.shape[1], held.shape[1]))
                self.shared.eliminated[key] = Far.of(sum(far(), start=none), free, self._differs, d, held)
            known = self.shared.eliminated[key]
            made = factorised(csr_matrix(known.rest + near()), free, d, held, known)
            self._factors |= {(name, *one): factor for one, factor in zip(ways, made, strict=True)}
        return self._factors[(name, *way)]

    def cycle_image(self, nodes: IntArray, forces: Array, further: Array) -> CycleImage:
        """The mirror by which most of s states are images of others, so that the fewest need be computed. The states
        are under forces (s, k, 3) on the nodes of index (k,).

        further: (s, f) numbers that must be equal in a state and its image: what else acts, symmetric about all planes.
        """
        count, everywhere = np.arange(len(forces)), np.arange(len(self.mesh.points))
        found = []
        for flipped in product((False, True), repeat=len(self.planes)):
            image, sides = everywhere, np.ones(3)
            for (axis, of_axis), is_flipped in zip(self._images.items(), flipped, strict=True):
                image, sides = (of_axis[image], sides * _signs(axis)) if is_flipped else (image, sides)
            is_image, source = _image_test(nodes, forces, further, image, sides), count.copy()
            for k in range(len(count)):
                source[k] = next((j for j in range(k) if source[j] == j and is_image(k, j)), k)
            found.append(CycleImage(sides, image, source))
        return min(found, key=lambda one: len(one.computed))

    def cycle_planes(self, nodes: IntArray, forces: Array, further: Array) -> tuple[int, ...]:
        """The axes of `planes` about which the mirror image of each state is a state of the cycle; as `cycle_image`."""
        count = range(len(forces))
        tests = {axis: _image_test(nodes, forces, further, of, _signs(axis)) for axis, of in self._images.items()}
        return tuple(axis for axis, test in tests.items() if all(any(test(k, j) for j in count) for k in count))

    def on_one_side(self, nodes: IntArray, planes: tuple[int, ...]) -> tuple[IntArray, Array]:
        """For each of nodes (k,) the node that is its image, or itself, where no coordinate along an axis of `planes`
        is negative; and the signs (k, 3) by which a vector there follows.
        """
        own, sides = nodes, np.ones((len(nodes), 3))
        for axis in planes:
            beyond = self.mesh.points[nodes, axis] < 0.0
            own, sides[beyond, axis] = np.where(beyond, self._images[axis][own], own), -1.0
        return own, sides

    def forget(self) -> None:
        """Drop factors that are not shared. They are made again when they are asked for."""
        self._factors.clear()

    def _stiff(self, odd: tuple[bool, ...], wanted: Iterable[tuple[bool, ...]]) -> Factor:
        """The factor of the stiffness for one of these symmetries."""
        ways, every = list(wanted), self._ways
        held, free = self._number[self.held], np.arange(len(self._nodes))
        held = held[held >= 0]
        of_ring = condensation.held_of_ring(self._piece, held)
        on_planes = condensation.held_on_planes(self._piece, self.planes)[[every.index(one) for one in ways]]
        if of_ring is None:
            free = np.setdiff1d(free, held)
        else:
            on_planes |= of_ring
        near, *far = self._elements

        def stiffness(mesh: HexMesh | QuadMesh, nodes: IntArray, is_last: bool) -> csr_matrix:
            found = self._widened(stiffness_matrix(mesh, self.material), nodes)
            if self.bedding is None or not is_last:
                return found
            return condensation.bedded(found, self._piece, self.planes, self.bedding[self._nodes])

        return self._factor(
            "stiffness",
            odd,
            ways,
            lambda: stiffness(*near, is_last=not far),
            lambda: [stiffness(*one, is_last=True) for one in far],
            (free, 3, on_planes),
        )

    def _parts(
        self, field: Callable[[IntArray], Array], nodes: IntArray, planes: tuple[int, ...]
    ) -> dict[tuple[bool, ...], Array]:
        """The parts (s, k, 3) of a vector field that are even or odd about each of the planes. field: gives it at nodes
        (k,).
        """
        if not planes:
            return {(): field(nodes)}
        *others, axis = planes
        here, there = (self._parts(field, of, tuple(others)) for of in (nodes, self._images[axis][nodes]))
        mirrored = {odd: part * _signs(axis) for odd, part in there.items()}
        even = {(*odd, False): 0.5 * (part + mirrored[odd]) for odd, part in here.items()}
        return even | {(*odd, True): 0.5 * (part - mirrored[odd]) for odd, part in here.items()}

    def _spread(self, result: Array, piece: Array, odd: tuple[bool, ...]) -> None:
        """Add the piece's field (s, p, 3) of one symmetry to the whole body's."""
        whole = np.zeros_like(result)
        whole[:, self._nodes] = piece
        known = self._number >= 0
        for (axis, image), is_odd in zip(self._images.items(), odd, strict=True):
            new = known[image] & ~known
            mirrored = whole[:, image[new]] * _signs(axis)
            whole[:, new] = -mirrored if is_odd else mirrored
            known |= new
        result += whole

    def _image(self, axis: int) -> IntArray | None:
        image = mirror_images(self.mesh, axis)
        if image is None or not np.array_equal(np.sort(image[self.held]), np.sort(self.held)):
            return None
        if self.bedding is not None and not np.allclose(self.bedding[image], self.bedding, rtol=1e-12, atol=0.0):
            return None
        return image


@dataclass
class EmbeddedInterior(Interior):
    """A block of own elements within a host, a body from a file that is held; `joined` is the stiffness of both, see
    `solvers.elasticity.embedding`.

    `mesh` is the block's, and displacements are given for its nodes only.
    """

    joined: Joined = field(kw_only=True)

    def _computed(self, nodes: IntArray, forces: Array) -> Array:
        size = self.joined.stiffness.shape[0]
        with threadpool_limits(limits=1, user_api="blas"):
            loads = np.zeros((len(forces), size // 3, 3))
            loads[:, nodes] = forces
            moved = self._of_both.solved(loads.reshape(len(forces), -1).T)
        return np.ascontiguousarray(moved.T.reshape(loads.shape)[:, : self.joined.block])

    @cached_property
    def _of_both(self) -> Factor:
        """The factor of block and host, of which all differs."""
        stiffness, free = self.joined.stiffness, self.joined.free
        none_held = np.zeros((1, stiffness.shape[0]), dtype=bool)
        none = Far.of(stiffness, free, np.ones(stiffness.shape[0] // 3, dtype=bool), 3, none_held)
        return factorised(stiffness, free, 3, none_held, none)[0]

    def _image(self, axis: int) -> None:
        """None: the host need not be its own mirror image."""


def _projected(mass: csr_matrix, zero: BoolArray, loads: Array) -> Array:
    """Nodal values (n, k) that loads (n, k) make with a mass matrix (n, n); 0 where `zero` (n,) is True."""
    found = np.zeros_like(loads)
    own = mass[~zero][:, ~zero]
    for k, column in enumerate(loads[~zero].T):
        found[~zero, k] = solved_for_mass(own, column)
    return found


def _image_test(
    nodes: IntArray, forces: Array, further: Array, image: IntArray, sides: Array
) -> Callable[[int, int], bool]:
    """Whether state k is the image of state j; as in `CycleImage` and `Interior.cycle_image`."""
    loaded = np.union1d(nodes, image[nodes])
    near = np.zeros((len(forces), len(loaded), 3))
    near[:, np.searchsorted(loaded, nodes)] = forces
    mirrored = near[:, np.searchsorted(loaded, image[loaded])] * sides
    least = _ALIKE * np.abs(forces).max(initial=0.0)

    def is_image(k: int, j: int) -> bool:
        return np.array_equal(further[k], further[j]) and bool(np.abs(near[k] - mirrored[j]).max(initial=0.0) <= least)

    return is_image


def _signs(axis: int) -> Array:
    return np.where(np.arange(3) == axis, -1.0, 1.0)
