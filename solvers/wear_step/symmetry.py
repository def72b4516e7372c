"""Symmetries of a fretting cycle: mirrors that map both bodies onto themselves, found by testing them.

Wires crossed at right angles are mirrored about the plane across the motion (y -> -y), which acts within each position
of the cycle, and about the plane along it (x -> -x), which reverses the motion: what happens at one position happens
mirrored half a cycle later. Wires crossed at any angle keep the turn by half a circle, both mirrors in one.
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
    """A map (x, y) -> (sign_x x, sign_y y) of the world that takes each body onto itself.

    primary, secondary: (n,) index of the patch node onto which each node of that body is mapped. With sign_x = -1 the
    motion is reversed, so what happens at one time happens mirrored half a cycle later.
    """

    sign_x: float
    sign_y: float
    primary: IntArray
    secondary: IntArray

    @property
    def signs(self) -> Array:
        """Factors of a vector's components in world axes, (3,)."""
        return np.array([self.sign_x, self.sign_y, 1.0])

    def image(self, field: NDArray[Any], images: IntArray) -> NDArray[Any]:
        """A field of numbers (n,), of vectors (n, 3) or many of these (m, n, 3) on one body's nodes, taken to their
        images (n,) on that body.
        """
        out = np.empty_like(field)
        if field.ndim == 1:
            out[images] = field
        else:
            out[..., images, :] = field * self.signs
        return out


@dataclass(frozen=True)
class Symmetry:
    """The symmetries of a cycle: `across` acts within a position, `half_cycle` between positions half a cycle apart."""

    across: Mirror | None = None
    half_cycle: Mirror | None = None

    @property
    def order(self) -> int:
        """Number of images of each unknown under the symmetries, itself included: 1, 2 or 4."""
        return (2 if self.across else 1) * self.strokes

    @property
    def strokes(self) -> int:
        """2 if half a cycle is traced, whose image is the other half; else 1."""
        return 2 if self.half_cycle else 1

    def under(self, drive: Drive) -> "Symmetry":
        """The symmetries that a cycle of this drive keeps.

        A mirror onto the other half of the cycle needs equal loading of both halves; one across the motion, surfaces
        that no bulk stress shears.
        """
        return Symmetry(None if drive.shears else self.across, self.half_cycle if drive.symmetric else None)


def symmetry_of(problem: ContactProblem) -> Symmetry:
    """The symmetries that the bodies have, each tested on meshes, unworn shapes and compliances."""
    across = _mirror(problem, 1.0, -1.0) if len(problem.primary.patch.transverse_mm) > 1 else None
    half_cycle = None
    if problem.upper.incline == 0.0 and problem.lower.incline == 0.0:
        half_cycle = _mirror(problem, -1.0, 1.0) or _mirror(problem, -1.0, -1.0)
    return Symmetry(across, half_cycle)


def kept_by(symmetry: Symmetry, state: ContactState) -> Symmetry:
    """The symmetries that also map the worn depths and prints of a state onto themselves, to within round-off."""

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
    """The state half a cycle away, by a mirror that reverses the motion; the worn surfaces are left as they are."""
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
    """A guide that covers the whole cycle, from one that may cover only one stroke.

    mirror: the map that reverses the motion. The other stroke follows from it, half a cycle later: displacements along
    x and tractions are mirrored, overlap areas kept. A guide of both strokes, or one without a mirror, is returned as
    it is.
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
    """Difference of a closed cycle's pressures from their own mirror image, 0 to 1; None without a symmetry, or if load
    or bulk stress differ.

    states: m states from one end of the stroke to itself; the state at its start may be the first.

    Half the area-weighted difference at each place, the largest over the cycle, over the cycle's largest load:
    numerical error alone, where bodies, rig and effects are symmetric. States on the way out are compared with those on
    the way back at the mirrored drive; those that one way has alone are left out. The largest load is the reference
    because bodies may nearly part on their way, where a single node would count for much of the load there.
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
