"""The flow of metal in bars, a beam and a thick sphere, beside closed forms.

Rows compare stresses in MPa, displacements in mm and strains of metals of `solvers.laws.plasticity`: bars pulled to and
fro with each hardening, a beam bent beyond first yield and let go, and a sphere under inner pressure that yields from
the inside (Hill, The Mathematical Theory of Plasticity (1950)).
"""

from collections.abc import Sequence

import numpy as np

from geometry import Elastic
from geometry.arrays import Array
from solvers.laws.plasticity import Flow, Metal, flown
from wirewear.verification.rows import Level, Row, compared

_STEEL, _LAME_MPa = Elastic(200_000.0, 0.3), 200_000.0 * 0.3 / 1.3 / 0.4
#: Metals of bars, the strains between which they are pulled, and their last stresses there in MPa.
_BARS = (
    ("kinematic hardening", Metal(300.0, 1e4), [0.006, -0.006, 0.006], [342.857, -342.857, 342.857]),
    ("mixed hardening", Metal(300.0, 1e4, 0.8), [0.006, -0.006] * 2, [342.857, -359.184, 375.199, -390.910]),
    ("hardening that saturates", Metal(300.0, 3e4, 1.0, 150.0), [0.006, -0.006] * 4, [406.694, -406.694]),
)
_BENT, _FIBRES = 1.58114, 100  #: Curvature over that of first yield, at 1.3 times its moment; fibres of half a beam.
#: Pressures in a sphere that let it yield to 12 and 15 mm, and the displacement of its inner face.
_SPHERE = ((221.827, 0.0106835), (299.087, 0.0235495))


def metal_rows(_level: Level) -> tuple[Row, ...]:
    """Rows on all bodies, at any level."""
    rows = []
    for name, metal, strains, expected in _BARS:
        found = stretched(metal, strains)[-len(expected) :]
        rows += [
            compared(f"Bar, {name}", f"stress at turn {turn} [MPa]", *pair, 1e-3)
            for turn, pair in enumerate(zip(found, expected, strict=True), 1)
        ]
    share = (np.arange(_FIBRES) + 0.5) / _FIBRES
    first = 300.0 / _STEEL.youngs_modulus_MPa
    stress = np.array([stretched(Metal(300.0), [_BENT * first * one], 1)[0] / 300.0 for one in share])
    moment = float(3.0 * (stress * share).mean())
    # The core's edge is no fibre, nor is the face.
    outside, edge = stress[-1] - moment, stress[int(_FIBRES / _BENT) + 1] - moment / _BENT
    rows += [
        compared("Beam bent beyond yield", "moment over that of first yield", moment, 1.3, 5e-3),
        compared("Beam let go", "curvature over that of first yield", _BENT - moment, 0.28114, 5e-3, scale=1.0),
        compared("Beam let go", "stress outside over yield stress", float(outside), -0.3, 5e-3, scale=1.0),
        compared("Beam let go", "stress at the core's edge over it", float(edge), 0.1778, 5e-3, scale=1.0),
    ]
    return *rows, *(
        compared(f"Sphere under {pressure:g} MPa", "inner face moves [mm]", expanded(pressure), moved, 5e-3)
        for pressure, moved in _SPHERE
    )


def stretched(metal: Metal, strains: Sequence[float], steps: int = 300) -> list[float]:
    """Axial stresses in MPa of a bar of steel at the turning points `strains` of its strain, in `steps` each."""
    shear = _STEEL.shear_modulus_MPa
    flow, found, last, across = Flow.none(1), list[float](), 0.0, 0.0

    def after(axial: float, lateral: float) -> tuple[Array, Flow]:
        strain = np.array([axial, lateral, lateral, 0.0, 0.0, 0.0])
        stress = 2.0 * shear * strain
        stress[:3] += _LAME_MPa * (axial + 2.0 * lateral)
        new = flown(metal, shear, stress[None] - 2.0 * shear * flow.strain, flow)
        return stress - 2.0 * shear * new.strain[0], new

    for goal in strains:
        for axial in np.linspace(last, goal, steps + 1)[1:].tolist():
            # The secant method finds the lateral strain that leaves the sides free.
            other = across - 1e-6
            (stress, new), (side, _) = after(axial, across), after(axial, other)
            while abs(stress[1]) > 1e-8:
                across, other, side = across - stress[1] * (across - other) / (stress[1] - side[1]), across, stress
                stress, new = after(axial, across)
            flow = new
        last = goal
        found.append(float(stress[0]))
    return found


def expanded(pressure_MPa: float, shells: int = 40) -> float:
    """Displacement in mm of the inner face of a sphere of steel of 10 and 20 mm radius, perfectly plastic at 250 MPa,
    by finite elements along its radius.
    """
    r = np.linspace(10.0, 20.0, shells + 1)
    middle, size = 0.5 * (r[1:] + r[:-1]), np.diff(r)
    # Strains rr, tt and tt at the middles by displacements of the shells' faces.
    slope = np.zeros((3, shells, shells + 1))
    for k in range(shells):
        slope[0, k, k : k + 2] = [-1.0 / size[k], 1.0 / size[k]]
        slope[1:, k, k : k + 2] = 0.5 / middle[k]
    volume, shear = middle**2 * size, _STEEL.shear_modulus_MPa
    law = 2.0 * shear * np.eye(3) + _LAME_MPa
    inverse = np.linalg.inv(np.einsum("akn,ab,bkm,k->nm", slope, law, slope, volume))
    flow, moved = Flow.none(shells), np.zeros(shells + 1)
    for pressure in np.linspace(0.0, pressure_MPa, 21)[1:].tolist():
        for _ in range(400):
            strain = np.einsum("akn,n->ka", slope, moved)
            trial = np.zeros((shells, 6))
            trial[:, :3] = strain @ law - 2.0 * shear * flow.strain[:, :3]
            new = flown(Metal(250.0), shear, trial, flow)
            stress = strain @ law - 2.0 * shear * new.strain[:, :3]
            left = -np.einsum("akn,ka,k->n", slope, stress, volume)
            left[0] += pressure * r[0] ** 2
            if np.abs(left).max() < 1e-5 * pressure * r[0] ** 2:
                break
            moved += inverse @ left
        flow = new
    return float(moved[0])
