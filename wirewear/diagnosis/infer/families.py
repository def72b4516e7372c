"""Families of distortions: low-rank spaces of what a cause outside the library may do at each seam.

The force channel, the displacement channel and the holder are the same throughout a test; what the contact, the load
and the surfaces do may change from cycle to cycle, by a Gaussian process over the logarithm of the cycles.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.in_time import FreeInTime
from wirewear.diagnosis.infer.inference import Problem
from wirewear.diagnosis.infer.profile_shapes import MIDDLE_AND_FLANKS, aside, aside_third, middle, widened, worn
from wirewear.diagnosis.infer.shapes import (
    Branches,
    Shape,
    displacement_after_play,
    displacement_read,
    force_after_play,
    force_read,
    loaded,
    resisting,
    stiffening,
    yielding,
)
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.setup import Array, Setup
from wirewear.diagnosis.observe.layout import Layout
from wirewear.diagnosis.observe.profiles import ProfileDepths
from wirewear.effects import Seam

_KNOWN = constants("infer.families")

#: Shares of the plateau force or of the amplitude by which a distortion is tried; none is more likely than another.
SIZES = _KNOWN.numbers("sizes")

#: Step of the derivatives, as such a share.
_STEP = _KNOWN.number("step")

#: What changes over the cycles does so over this difference of their logarithm, as Matérn's process of order 1/2.
REACH, KNOTS = _KNOWN.number("reach"), _KNOWN.count("knots")

#: Share of a developing distortion's variance that stays the same throughout.
LASTING = _KNOWN.number("lasting")

#: Lengths of what passes after a reversal, shares of the amplitude of which the contact has slid.
LENGTHS = _KNOWN.numbers("lengths")

#: Friction that creeps before it slides, as Dahl's does, resembles a holder that slips: by up to so much log evidence.
MICRO_SLIP = _KNOWN.number("micro_slip")

#: What solvers differ in beside the learned sizes resembles two families more than others: by up to so much of it.
SOLVERS = _KNOWN.number("solvers")

#: What a mesh's own walls lend to families that are odd in the place.
WALLS = _KNOWN.number("walls")

#: Shares of the plateau force at which a holder lets go.
RELEASES = _KNOWN.numbers("releases")


@dataclass(frozen=True, eq=False)
class Family:
    """Distortions of one kind at one seam.

    Attributes:
        seam: where they enter.
        name: what they are, for people.
        shapes: of a loop, each with a size of its own; empty for what changes in time.
        column: of the chain, where it changes in time; empty for shapes.
        scale: unit of what is added to the column: "" multiplies it, "compliance" is amplitude over plateau force,
            "force" that force.
        develops: whether its sizes may change over the cycles.
        allowed: log evidence that friction laws and solvers were seen to lend it beside known effects.
        or_shape: one that it may have instead of all others, as likely as these.
    """

    seam: Seam
    name: str
    shapes: tuple[Shape, ...] = ()
    column: str = ""
    scale: str = ""
    develops: bool = False
    allowed: float = 0.0
    or_shape: Shape | None = None


def _odd(u: Array) -> Array:
    return np.asarray(u**3 - u)


def _cubic(u: Array) -> Array:
    return np.asarray(u**3)


def _odd_fifth(u: Array) -> Array:
    return np.asarray(u**5 - u**3)


def _even(u: Array) -> Array:
    return np.asarray(u**2 - 1.0)


def _even_fourth(u: Array) -> Array:
    return np.asarray(u**4 - u**2)


def _bowl(b: Branches) -> Array:
    return np.asarray(b.place**2 - 1.0 / 3.0)


def _bowl_fourth(b: Branches) -> Array:
    return np.asarray(b.place**4 - 0.2)


def _direction(b: Branches) -> Array:
    """+1 on the branch towards +x, −1 on the other."""
    return np.broadcast_to(np.array([1.0, -1.0])[None, :, None], b.place.shape)


#: Places fixed to the rig: x over the amplitude.
def _tilt(b: Branches) -> Array:
    return np.asarray(_direction(b) * b.place)


def _tilt_third(b: Branches) -> Array:
    return np.asarray(_direction(b) * b.place**3)


def _uphill(b: Branches) -> Array:
    return b.place


def _uphill_third(b: Branches) -> Array:
    return np.asarray(b.place**3)


def _uphill_fifth(b: Branches) -> Array:
    return np.asarray(b.place**5)


def _sided(b: Branches) -> Array:
    return np.asarray(_direction(b) * b.place**2)


def _since(length: float) -> Shape:
    return resisting(lambda b: np.asarray(np.exp(-b.slid / length)))


#: All of them. What the library holds (a gain, a compliance, an offset of friction) lies in none.
FAMILIES: tuple[Family, ...] = (
    Family(
        Seam.SENSOR,
        "distortion of the force channel, odd in Q",
        (force_read(_odd), force_read(_odd_fifth)),
        # A cell that saturates is right at small forces: it reads plateaus lower, stick branches bent, and nothing else
        # of a lower friction. Shapes that leave the plateaus where they are see a small part of that.
        or_shape=force_read(_cubic),
    ),
    Family(Seam.SENSOR, "distortion of the force channel, even in Q", (force_read(_even), force_read(_even_fourth))),
    Family(
        Seam.SENSOR,
        "distortion of the displacement channel, odd in the displacement",
        (displacement_read(_odd), displacement_read(_odd_fifth)),
        allowed=SOLVERS,
    ),
    Family(
        Seam.SENSOR,
        "distortion of the displacement channel, even in the displacement",
        (displacement_read(_even), displacement_read(_even_fourth)),
    ),
    Family(Seam.SENSOR, "force channel that comes after the force by a play", (force_after_play(),)),
    Family(
        Seam.SENSOR,
        "displacement channel that comes after the motion by a play",
        (displacement_after_play(held=True), displacement_after_play(held=False)),
    ),
    Family(Seam.SENSOR, "gain of the displacement channel that changes over the test", column="gain"),
    Family(Seam.SENSOR, "zero of the force channel that changes over the test", column="force_zero_N", scale="force"),
    Family(
        Seam.HOLDER,
        "holder that slips, with hysteresis",
        tuple(yielding(at) for at in RELEASES),
        allowed=MICRO_SLIP,
    ),
    Family(
        Seam.HOLDER,
        "holder that stiffens or softens under the force, alike in both directions",
        (stiffening(),),
    ),
    Family(
        Seam.HOLDER,
        "holder whose compliance changes over the test",
        column="compliance_um_per_N",
        scale="compliance",
    ),
    Family(
        Seam.CONTACT,
        "friction that differs along the stroke, alike on both sides of its middle",
        (resisting(_bowl), resisting(_bowl_fourth)),
        develops=True,
    ),
    Family(
        Seam.CONTACT,
        "friction that differs along the stroke from one side to the other",
        (resisting(_tilt), resisting(_tilt_third)),
        develops=True,
        allowed=WALLS,
    ),
    Family(
        Seam.CONTACT,
        "friction that passes after each reversal",
        tuple(map(_since, LENGTHS)),
        develops=True,
        allowed=SOLVERS,
    ),
    Family(Seam.CONTACT, "friction that changes over the test", column="friction"),
    Family(
        Seam.LOADING,
        "load that differs along the stroke, alike on both sides of its middle",
        (loaded(_bowl), loaded(_bowl_fourth)),
    ),
    Family(
        Seam.LOADING,
        "load that differs along the stroke from one side to the other",
        (loaded(_tilt), loaded(_tilt_third)),
    ),
    Family(Seam.LOADING, "load that changes over the test", column="load_N"),
    Family(
        Seam.SPECIMENS,
        "force that follows the place, as slopes of a surface make it",
        (resisting(_uphill), resisting(_uphill_third), resisting(_uphill_fifth), resisting(_sided)),
        develops=True,
        allowed=WALLS,
    ),
    Family(Seam.WEAR, "wear that goes faster and slower over the test", column="wear_um3_per_mJ"),
)


#: Those of the profiles that line contacts leave.
PROFILE_FAMILIES: tuple[Family, ...] = (
    Family(Seam.WEAR, MIDDLE_AND_FLANKS, (worn(middle(0.4)), worn(middle(0.2)))),
    Family(Seam.WEAR, "wear that differs from one side of the scar to the other", (worn(aside), worn(aside_third))),
    Family(Seam.SPECIMENS, "scar of another width than the worn material makes", (widened,)),
)


@dataclass(frozen=True, eq=False)
class Columns:
    """A family around one explanation.

    Attributes:
        family: whose they are.
        weight: belief in them before looking, among all of one family.
        observed: (n, k) changes of the observables by a standard deviation of each of its k unknowns, of unit size.
        knots: (j,) logarithms of the cycles between which what changes in time goes straight; empty for shapes.
        of_unknowns: (j, k) its values there by its unknowns.
    """

    family: Family
    weight: float
    observed: Array
    knots: Array
    of_unknowns: Array


def families_of(layout: Layout) -> tuple[Family, ...]:
    """Those that a layout can show: of loops, of what changes over several logged cycles, of profiles."""
    loops = any(not part.observable.of_scars for part in layout)
    several = np.unique(layout.cycle).size > 1
    found = tuple(one for one in FAMILIES if loops and (several or not one.column))
    return (*found, *PROFILE_FAMILIES) if layout.of_kind(ProfileDepths).any() else found


def columns_of(problem: Problem, setup: Setup) -> tuple[tuple[Columns, ...], ...]:
    """All families around a setup; of each, the columns that it may have, one set instead of another."""
    layout, states = problem.layout, problem.states
    course = simulate(states, setup, layout.cycles)
    base = layout.observed(course)
    branches = Branches.of(course, setup.amplitude_um, setup.plateau_force_N)
    logged = np.log(np.unique(np.maximum(layout.cycle, 1)).astype(float))
    knots = np.linspace(logged[0], logged[-1], min(KNOTS, logged.size))
    found = []
    for family in families_of(layout):
        if family.shapes:
            columns = np.nan_to_num(np.column_stack(list(_of_shapes(family, problem, branches, base, logged))))
            sets = [columns]
            if family.or_shape is not None:
                sets.append(np.nan_to_num((layout.observed(family.or_shape(branches, _STEP)) - base) / _STEP)[:, None])
            nowhere = np.zeros(0), np.zeros((0, 0))
            found.append(tuple(Columns(family, 1.0 / len(sets), one, *nowhere) for one in sets))
        else:
            found.append(_courses(family, problem, setup, base, knots))
    return tuple(found)


def _courses(family: Family, problem: Problem, setup: Setup, base: Array, knots: Array) -> tuple[Columns, ...]:
    """Columns of what changes in time: freely, or, as likely as that, towards a final value as creep and warmth do."""
    free: Array = np.asarray(np.linalg.cholesky(_kernel(knots, 0.0)), dtype=np.float64)
    observed = np.nan_to_num(np.column_stack(list(_in_time(family, problem, setup, base, knots, free))))
    found = [Columns(family, 0.5, observed, knots, free)]
    # Linear in the values at knots, as the free courses are.
    by_values = observed @ np.linalg.inv(free)
    for late in knots[1:]:
        settling = (1.0 - np.exp(-np.exp(knots - late)))[:, None]
        found.append(Columns(family, 0.5 / (knots.size - 1), by_values @ settling, knots, settling))
    return tuple(found)


def _of_shapes(family: Family, problem: Problem, branches: Branches, base: Array, logged: Array) -> Iterator[Array]:
    row = np.searchsorted(logged, np.log(np.maximum(problem.layout.cycle, 1)) - 1e-9)
    for shape in family.shapes:
        change = (problem.layout.observed(shape(branches, _STEP)) - base) / _STEP
        if not family.develops:
            yield change
            continue
        for weights in np.linalg.cholesky(_kernel(logged, LASTING)).T:
            yield change * weights[row]


def _in_time(
    family: Family, problem: Problem, setup: Setup, base: Array, knots: Array, values: Array
) -> Iterator[Array]:
    force = setup.plateau_force_N
    scale = {"": 0.0, "force": force, "compliance": setup.amplitude_um / force}[family.scale]
    for weights in values.T:
        moved = FreeInTime(family.column, knots, _STEP * weights, scale)
        changed = replace(setup, effects=(*setup.effects, moved))
        course = simulate(problem.states, changed, problem.layout.cycles)
        yield (problem.layout.observed(course) - base) / _STEP


def _kernel(time: Array, lasting: float) -> Array:
    """Covariance (k, k) of a size over logarithms of cycles (k,)."""
    apart = np.abs(time[:, None] - time)
    kernel: Array = lasting + (1.0 - lasting) * np.exp(-apart / REACH) + 1e-9 * np.eye(time.size)
    return kernel
