"""Worn surfaces transferred to another patch grid, with worn volume and energy conserved, or flattened before any wear.

The bilinear field of depth or energy is projected in L2 onto the new grid's bilinear fields. Both grids are
rectilinear, so the projection is that along one axis followed by that along the other, and all integrals of products of
hat functions are exact. The projection conserves the integral and is second-order accurate, but may undershoot next to
kinks, where depth must not become negative. There its difference from the projection with lumped mass, which is a mean
of the old field and never negative, is limited as in flux-corrected transport (Zalesak, J. Comput. Phys. 31 (1979) 335;
for projections: Farrell et al., Comput. Methods Appl. Mech. Eng. 198 (2009) 2632): what one node does not give, its
neighbour does not receive, so the integral stays. A projection that is nowhere negative is not changed; that onto the
same grid returns the field itself.

A body is flattened wherever the other one presses on it during the stroke. The remaining shapes then conform within the
overlap, as after plastic contact without pile-up (Johnson, Contact Mechanics (1985), ch. 6).
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import solveh_banded

from geometry import ContactPatch
from geometry.arrays import Array, BoolArray
from geometry.patch import linear_weights
from solvers.contact import ContactProblem, press, unloaded_state
from solvers.contact_state import ContactState, IncrementReport, WearState
from solvers.elasticity.pairing import PrimarySurface, primary_surface, vertical_gap
from solvers.errors import SolverError


def remeshed(
    problem: ContactProblem, state: ContactState, onto: ContactProblem
) -> tuple[ContactState, IncrementReport]:
    """The state transferred to the bodies of the problem `onto`, pressed together without friction at the same drive;
    and the report of pressing.

    Worn volume and the height to which the loading spring refers are kept; tangential tractions are lost, and half a
    cycle without wear restores them. Raises SolverError if a worn node lies outside its new patch, or no contact was
    found.
    """
    old, new = ((of.primary.patch, of.secondary.patch) for of in (problem, onto))
    blank = unloaded_state(onto)
    carried = replace(blank, wear=transferred_wear(state.wear, old, new), drive=state.drive, bulk=state.bulk)
    pressed, report = press(onto, carried)
    return replace(pressed, pressed_z=state.pressed_z), report


def transferred_wear(
    wear: WearState, old: tuple[ContactPatch, ContactPatch], new: tuple[ContactPatch, ContactPatch]
) -> WearState:
    """Worn depths, energies, prints, debris and temperatures on new patches; `old` and `new` are the patches of
    (primary, secondary).

    Raises SolverError when a worn node lies outside its new patch.
    """
    (old_primary, old_secondary), (new_primary, new_secondary) = old, new
    return replace(
        wear,
        primary_depth=transferred(wear.primary_depth, old_primary, new_primary),
        secondary_depth=transferred(wear.secondary_depth, old_secondary, new_secondary),
        primary_energy=transferred(wear.primary_energy, old_primary, new_primary),
        secondary_energy=transferred(wear.secondary_energy, old_secondary, new_secondary),
        primary_print=_transferred_print(wear.primary_print, old_primary, new_primary),
        secondary_print=_transferred_print(wear.secondary_print, old_secondary, new_secondary),
        primary_debris=_transferred_print(wear.primary_debris, old_primary, new_primary),
        secondary_debris=_transferred_print(wear.secondary_debris, old_secondary, new_secondary),
        primary_rise=_interpolated(wear.primary_rise, old_primary, new_primary),
        secondary_rise=_interpolated(wear.secondary_rise, old_secondary, new_secondary),
    )


def _transferred_print(depth: Array | None, old: ContactPatch, new: ContactPatch) -> Array | None:
    if depth is None:
        return None
    # Beside a print it may stand out a little.
    return transferred(np.maximum(depth, 0.0), old, new) - transferred(np.maximum(-depth, 0.0), old, new)


def _interpolated(rise: Array | None, old: ContactPatch, new: ContactPatch) -> Array | None:
    if rise is None:
        return None
    along = linear_weights(old.axial_mm, new.axial_mm)
    return np.asarray(along @ rise @ linear_weights(old.transverse_mm, new.transverse_mm).T)


def transferred(field: Array, old: ContactPatch, new: ContactPatch) -> Array:
    """A non-negative field (n_a, n_t) at the old patch's nodes as one at the new patch's, with the same integral, never
    negative.

    Raises SolverError when the field is not zero outside the new patch.
    """
    along = _transferred_along(field, old.axial_mm, new.axial_mm)
    moved = _transferred_along(along.T, old.transverse_mm, new.transverse_mm).T
    before, after = (float((f.ravel() * p.node_areas()).sum()) for f, p in ((field, old), (moved, new)))
    # The share of a field's integral that may lie beside the new grid: round-off.
    if before - after > 1e-11 * before:
        raise SolverError(
            f"the new contact patch (half-extents {new.axial_mm[-1]:.4g} and {new.transverse_mm[-1]:.4g} mm) is "
            f"smaller than the scar: {100.0 * (1.0 - after / before):.2g} % of it lie beside it; give the new mesh a "
            "wider patch"
        )
    return moved


def lies_within(marked: BoolArray, old: tuple[Array, Array], new: tuple[Array, Array]) -> bool:
    """True if a field, bilinear between the lines `old` along and across and not zero at `marked` nodes (n_a, n_t), is
    zero beyond the lines `new`: it falls to zero within an element beside these nodes.
    """
    for axis, (lines, others) in enumerate(zip(old, new, strict=True)):
        at = np.flatnonzero(marked.any(axis=1 - axis))
        if at.size:
            first, last = lines[max(at[0] - 1, 0)], lines[min(at[-1] + 1, len(lines) - 1)]
            if first < (1.0 + 1e-9) * others[0] or last > (1.0 + 1e-9) * others[-1]:
                return False
    return True


def _transferred_along(field: Array, old: Array, new: Array) -> Array:
    """Transfer a field along its first axis, from (len(old), m) to (len(new), m); a planar body has one line across."""
    if len(old) == len(new) == 1:
        return field
    moments = hat_products(new, old) @ field
    spacing = np.diff(new)
    lumped_mass = np.zeros(len(new))
    lumped_mass[:-1] += spacing / 2.0
    lumped_mass[1:] += spacing / 2.0
    # Of the consistent mass, two thirds of the lumped one are on the diagonal and a sixth of each spacing beside it.
    bands = np.stack([np.append(0.0, spacing / 6.0), 2.0 / 3.0 * lumped_mass])
    projected = solveh_banded(bands, moments)
    flux = spacing[:, None] / 6.0 * (projected[:-1] - projected[1:])
    lowered = np.zeros_like(projected)
    lowered[:-1] += np.minimum(flux, 0.0)
    lowered[1:] += np.minimum(-flux, 0.0)
    share = np.minimum(1.0, np.divide(moments, -lowered, out=np.ones_like(moments), where=lowered < 0.0))
    flux *= np.where(flux > 0.0, share[1:], share[:-1])
    moments[:-1] += flux
    moments[1:] -= flux
    return np.asarray(np.maximum(moments / lumped_mass[:, None], 0.0))


def spread_once(field: Array, patch: ContactPatch) -> Array:
    """A nodal field (n_a, n_t) of a patch with each value replaced by the mean over the node's support (the cells
    around it), weighted with its shape function; the field's integral stays.
    """
    for lines in (patch.axial_mm, patch.transverse_mm):
        if len(lines) > 1:
            products = hat_products(lines, lines)
            field = products @ field / products.sum(axis=1)[:, None]
        field = field.T
    return field


def hat_products(first: Array, second: Array) -> Array:
    """Integrals (m, n) of products of the hat functions of two grids, of increasing lines (m,) and (n,), over their
    common interval.
    """
    low, high = max(first[0], second[0]), min(first[-1], second[-1])
    lines = np.unique(np.concatenate([first, second]).clip(low, high))
    # Between neighbouring lines the product is a quadratic, for which two Gauss points are exact.
    abscissae, weights = np.polynomial.legendre.leggauss(2)
    half = 0.5 * np.diff(lines)
    points = (0.5 * (lines[:-1] + lines[1:])[:, None] + half[:, None] * abscissae).ravel()
    measure = (half[:, None] * weights).ravel()
    return (hats(first, points).T * measure) @ hats(second, points)


def hats(lines: Array, points: Array) -> Array:
    """Values (p, l) of the hat functions of l grid lines at p points inside the grid."""
    cell = np.clip(np.searchsorted(lines, points, side="right") - 1, 0, len(lines) - 2)
    along = (points - lines[cell]) / (lines[cell + 1] - lines[cell])
    values = np.zeros((len(points), len(lines)))
    rows = np.arange(len(points))
    values[rows, cell], values[rows, cell + 1] = 1.0 - along, along
    return values


def flattened(
    problem: ContactProblem, state: ContactState, approach_mm: float, slip_amplitude_mm: float
) -> ContactState:
    """The state with both surfaces flattened before any wear, wherever the other body presses on them over the whole
    stroke.

    approach_mm: by which the rigid bodies overlap; half of the overlap is taken from each, and nothing if it is 0.
    slip_amplitude_mm: half of the stroke. Depths and volumes of the flats count as worn.
    """
    if approach_mm == 0.0:
        return state
    primary = _depth(problem.surface, problem, approach_mm, slip_amplitude_mm)
    secondary = _depth(primary_surface(problem.secondary), problem, approach_mm, slip_amplitude_mm)
    wear = replace(
        state.wear,
        primary_depth=state.wear.primary_depth + primary,
        secondary_depth=state.wear.secondary_depth + secondary,
        primary_volume_mm3=state.wear.primary_volume_mm3 + _volume(primary, problem.primary.patch.node_areas()),
        secondary_volume_mm3=state.wear.secondary_volume_mm3 + _volume(secondary, problem.secondary.patch.node_areas()),
    )
    return replace(state, wear=wear)


def _depth(surface: PrimarySurface, problem: ContactProblem, approach: float, amplitude: float) -> Array:
    """Half of the largest overlap (n_a, n_t) in mm at each node of the body of `surface` over the stroke."""
    is_primary = surface.body is problem.primary
    other = problem.secondary if is_primary else problem.primary
    unworn = np.zeros(surface.body.patch.shape), np.zeros(other.patch.shape)
    at_rest = vertical_gap(surface, other, problem.offset(0.0, 0.0), *unworn)
    half_width = float(np.ptp(surface.body.node_positions[at_rest < approach, 0])) / 2.0 or amplitude
    # Positions along the stroke at which the other body presses, per half-width of the flattened spot.
    count = 2 * int(np.ceil(4.0 * amplitude / half_width)) + 1
    closest = at_rest
    for drive in np.linspace(-amplitude, amplitude, count):
        offset = problem.offset(float(drive), 0.0)
        closest = np.minimum(closest, vertical_gap(surface, other, offset if is_primary else -offset, *unworn))
    return 0.5 * np.maximum(approach - closest, 0.0).reshape(surface.body.patch.shape)


def _volume(depth: Array, areas: Array) -> float:
    return float(depth.ravel() @ areas)
