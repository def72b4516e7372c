"""Symmetries of a fretting cycle: mirrors that map both bodies onto themselves, found by testing them.

Wires crossed at right angles are mirrored about the plane y = 0, which acts within each position of the cycle
(`across`), and about x = 0, which reverses the motion (`half_cycle`): what happens at one position happens mirrored
half a cycle later. Wires crossed at any angle keep the turn by half a circle about z, both mirrors in one.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array, IntArray
from solvers.contact import ContactProblem
from solvers.contact_state import ContactState, Guide
from solvers.drive import Drive
from solvers.elasticity.placement import known_images

# Worn depths, relative to the deepest: those of runs that kept the symmetry differ by what Newton's method leaves.
_DEPTH_TOLERANCE = 1e-6
_SAME_DRIVE = 1e-9  # Drives closer than this, relative to the amplitude, are the same.


@dataclass(frozen=True)
class Mirror:
    """A map (x, y) -> (sign_x x, sign_y y) of the world that takes each body onto itself; each sign is 1 or -1.

    primary, secondary: (n,) index of the patch node onto which each node of that body is mapped. With sign_x = -1 the
    motion is reversed, so what happens at one time happens mirrored half a cycle later.
    """

    sign_x: float
    sign_y: float
    primary: IntArray
    secondary: IntArray

    @property
    def signs(self) -> Array:
        return np.array([self.sign_x, self.sign_y, 1.0])

    def image(self, field: NDArray[Any], images: IntArray) -> NDArray[Any]:
        """The mirror image of a nodal field: of numbers (n,), or of vectors (n, 3) or (m, n, 3), whose components
        change by `signs`. images: (n,) node onto which each is mapped, `primary` or `secondary`.
        """
        out = np.empty_like(field)
        if field.ndim == 1:
            out[images] = field
        else:
            out[..., images, :] = field * self.signs
        return out


@dataclass(frozen=True)
class Symmetry:
    """The mirrors of a cycle: `across` acts within each position, `half_cycle` between positions half a cycle apart;
    None where the bodies have none.
    """

    across: Mirror | None = None
    half_cycle: Mirror | None = None

    @property
    def order(self) -> int:
        """Number of places that are alike by the mirrors, over a whole cycle: 1, 2 or 4."""
        return (2 if self.across else 1) * self.strokes

    @property
    def strokes(self) -> int:
        """How many traced parts make a whole cycle: 2 if the other half is the traced one's mirror image; else 1."""
        return 2 if self.half_cycle else 1

    def under(self, drive: Drive) -> "Symmetry":
        """A symmetry with the mirrors that a cycle of this drive keeps, and None for others.

        `half_cycle` is kept if both halves are loaded alike, `across` if no bulk stress shears the surfaces.
        """
        return Symmetry(None if drive.shears else self.across, self.half_cycle if drive.symmetric else None)


def symmetry_of(problem: ContactProblem) -> Symmetry:
    """The mirrors that the unworn bodies have, each tested on meshes, shapes and compliances. A motion tilted out of
    the plane of contact has no `half_cycle`.
    """
    across = _mirror(problem, 1.0, -1.0) if len(problem.primary.patch.transverse_mm) > 1 else None
    half_cycle = None
    if problem.upper.incline == 0.0 and problem.lower.incline == 0.0:
        half_cycle = _mirror(problem, -1.0, 1.0) or _mirror(problem, -1.0, -1.0)
    return Symmetry(across, half_cycle)


def kept_by(symmetry: Symmetry, state: ContactState) -> Symmetry:
    """A symmetry with the mirrors that map a state's worn depths onto themselves, within 1e-6 of the deepest, and its
    prints, within 5 % of the deepest; None for others.
    """

    def kept(mirror: Mirror | None) -> Mirror | None:
        if mirror is None:
            return None
        images = mirror.primary, mirror.secondary
        # The same of prints, which one half of a cycle leaves a little before the other.
        for depths, tolerance in ((state.wear.depths, _DEPTH_TOLERANCE), (state.wear.prints, 0.05)):
            for depth, there in zip(depths, images, strict=True):
                flat = np.zeros(len(there)) if depth is None else depth.ravel()
                if np.abs(flat - flat[there]).max() > tolerance * float(np.abs(flat).max()):
                    return None
        return mirror

    return Symmetry(kept(symmetry.across), kept(symmetry.half_cycle))


def mirrored(state: ContactState, mirror: Mirror) -> ContactState:
    """The state half a cycle later, by a mirror that reverses the motion; worn depths and prints are unchanged."""
    return replace(
        state,
        drive=mirror.sign_x * state.drive + 0.0,
        holder_x=mirror.sign_x * state.holder_x,
        holder_tilt=mirror.sign_x * state.holder_tilt,
        traction=mirror.image(state.traction, mirror.primary),
        primary_force=mirror.image(state.primary_force, mirror.primary),
        secondary_force=mirror.image(state.secondary_force, mirror.secondary),
        core=mirror.image(state.core, mirror.primary),
        pressed_ahead=mirror.sign_x * state.pressed_ahead,
        slip_share=mirror.sign_x * mirror.image(state.slip_share, mirror.primary),
    )


def with_images(guide: Guide, mirror: Mirror | None) -> Guide:
    """A guide for the whole cycle, from one of a single stroke: the other stroke follows as its mirror image half a
    cycle later.

    mirror: one that reverses the motion, or None. A guide of both strokes, or any without a mirror, is returned as it
    is.
    """
    falling = guide.phase <= 0.5
    if mirror is None or (falling.any() and not falling.all()):
        return guide
    half = -0.5 if falling.any() else 0.5
    order = slice(None) if falling.any() else slice(None, None, -1)
    parts = (
        (guide.phase, guide.phase - half),
        (guide.drive, mirror.sign_x * guide.drive),
        (guide.holder_x, mirror.sign_x * guide.holder_x),
        (guide.overlap_area, guide.overlap_area),
        (guide.traction, mirror.image(guide.traction, mirror.primary)),
    )
    return Guide(*(np.concatenate(both[order]) for both in parts))


def mirror_error(problem: ContactProblem, states: tuple[ContactState, ...], symmetry: Symmetry) -> float | None:
    """Largest difference over a closed cycle between pressures and their own mirror image, as a share (0 to 1) of the
    cycle's largest load: numerical error alone where bodies, rig and effects are symmetric. None without a `half_cycle`
    mirror, or if load or bulk stress differ at mirrored places.

    states: from one end of the stroke to itself; the state at its start may be the first. States on the way out are
    compared with those on the way back at the mirrored drive, and left out if there are none; each difference is half
    the sum of |pressure - image| times area. The largest load is the reference because bodies may nearly part on their
    way, where a single node would count for much of the load there.
    """
    mirror = symmetry.half_cycle
    if mirror is None:
        return None
    drives = np.array([state.drive for state in states])
    reversal = int(np.argmax(np.abs(drives - drives[-1])))
    unit = _SAME_DRIVE * float(np.abs(drives).max())
    later = {round(state.drive / unit): state for state in states[reversal:]}
    areas, worst = problem.surface.areas, 0.0
    load = max(float(areas @ state.traction[:, 2]) for state in states)
    for state in states[: reversal + 1]:
        partner = later.get(round(mirror.sign_x * state.drive / unit))
        if partner is not None:
            if abs(partner.load_share - state.load_share) > _SAME_DRIVE or (partner.bulk != state.bulk).any():
                return None
            own, image = state.traction[:, 2], partner.traction[mirror.primary, 2]
            worst = max(worst, 0.5 * float(areas @ np.abs(own - image)))
    return worst / load if load > 0.0 else 0.0


def _mirror(problem: ContactProblem, sign_x: float, sign_y: float) -> Mirror | None:
    primary, secondary = (known_images(body, (sign_x, sign_y)) for body in (problem.primary, problem.secondary))
    if primary is None or secondary is None:
        return None
    return Mirror(sign_x, sign_y, primary, secondary)
