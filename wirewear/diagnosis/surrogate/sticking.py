"""Wear states of a nominal run whose contact sticks in its middle: stiffness K and order n of micro-slip at each
volume.

After a reversal, a branch travels n Q/K (1 − (1 − ΔQ/2µP)^(1/n)) while its force changes by ΔQ: Mindlin's micro-slip
with n = 3/2, by Masing's rule twice the first loading. Under another load or friction it follows the law of Ciavarella
(1998) and Jäger: force over friction is a function of the travel over that of full slip. K and n of a loop are those
that give its travel and its energy; what its branches then still differ by are their bends: where the annulus has worn,
the core alone is stiff, and a branch is almost straight once the annulus has given way.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wirewear.base.errors import RunError
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.surrogate.loop_states import (
    EVEN_POWERS,
    LIFT_POWERS,
    ODD_POWERS,
    StatesOfLoops,
    load_shares,
    scar_figures_of,
)
from wirewear.diagnosis.surrogate.sensed_loops import BENDS, WAVES
from wirewear.diagnosis.surrogate.springs import yielding_of
from wirewear.results import Loop, RunResult
from wirewear.test import study_from_tables

if TYPE_CHECKING:
    from geometry.arrays import Array

_KNOWN = constants("surrogate.sticking")

#: Standard deviations of the fast model's numerical freedoms where a contact sticks in its middle: meshes that are made
#: for what slips know its stiffness, and its order, as well as those of lines do.
FREEDOMS = dict.fromkeys(("stick_factor", "micro_slip"), _KNOWN.number("stick_factor"))

#: Orders that a contact may have, and shares of the friction at which a loop shows one.
_ORDERS, _SHARES = _KNOWN.pair("orders"), _KNOWN.pair("shares")


def sticks(result: RunResult) -> bool:
    """True if no loop of a run slides as a whole, under the friction of its bodies or of the layers on them."""
    study = study_from_tables(result.study, result.label)
    layers = [layer.friction for own in study.layers.values() for layer in own]
    friction = min(study.contact.friction, *(own for own in (*layers, np.inf) if own is not None))
    of_loops = [(loop, load_shares(result, loop)) for loop in result.loops]
    return all(share_of(loop, friction, of_load) < _SHARES[1] for loop, of_load in of_loops)


class StickingStates(StatesOfLoops):
    """Fields of `WearStates` of a contact that sticks in its middle."""

    yields: Array


def worn_as_far(share: Array, run_share: Array) -> Array:
    """What a contact at `run_share` of its friction has worn off when its annulus is as far from its end, over what one
    at `share` has.

    All that wears until slip ends under a held approach and stroke grows as q^2.6 (1 − q)^−0.4: Ciavarella and Hills
    (1999) within 4 % from 0.1 to 0.95.
    """
    own, run = (np.clip(one, 0.02, 0.98) for one in (share, run_share))
    return np.asarray((run / own) ** 2.6 * ((1.0 - own) / (1.0 - run)) ** 0.4)


def sticking_states(result: RunResult, friction: float, has_maps: bool = True) -> StickingStates:
    """Fields of `WearStates` from a run's loops, one row for each; two equal rows if there is only one.

    friction: coefficient of the run. has_maps: True if scars are read from maps; False for profiles, whose figures are
    0. Raises RunError if no loop carries a force.
    """
    rows = [row for loop in result.loops if (row := _row(loop, friction, load_shares(result, loop))) is not None]
    if not rows:
        raise RunError(f"no loop of the nominal run {result.name!r} carries a tangential force.")
    # A test that is logged once goes on as it is.
    found = np.array(rows if len(rows) > 1 else 2 * rows)
    cycles, stiffness = found.T[:2]
    volume = 1e9 * np.interp(cycles, result.evolution["cycle"], result.worn_volume_mm3)
    volume = np.maximum.accumulate(volume + 1e-9 * np.arange(volume.size) * max(float(volume[-1]), 1.0))
    count = volume.size
    return StickingStates(
        volume_um3=volume,
        similarity=volume,
        slip_um=np.ones(count),
        slope=np.zeros((count, len(ODD_POWERS))),
        angle=np.zeros((count, len(EVEN_POWERS))),
        stiffness_N_per_um=stiffness,
        load_drop_N=np.zeros(count),
        lift_N=np.zeros((count, len(LIFT_POWERS))),
        stroke_um=max(0.5 * float(np.ptp(loop.displacement_um)) for loop in result.loops),
        scars=np.array([[scar_figures_of(result, int(cycle), body)[0] for body in result.bodies] for cycle in cycles])
        if has_maps
        else np.zeros((count, 2, 4)),
        yields=np.column_stack([np.clip(found[:, 2], *_ORDERS), found[:, 3:]]),
    )


def share_of(loop: Loop, friction: float, of_load: Array | float = 1.0) -> float:
    """Half the range of a loop's tangential force over the sliding force µP; under a load that varies in the cycle,
    that of the force over `of_load`. of_load: (n,) load at each sample over the test's.
    """
    return float(0.5 * np.ptp(loop.tangential_force_N / of_load) / (friction * _steady_N(loop, of_load)))


def _steady_N(loop: Loop, of_load: Array | float) -> float:
    """The test's load in N, from a loop whose load at each sample is `of_load` times as large."""
    shares = np.broadcast_to(of_load, loop.normal_force_N.shape)
    return float(loop.normal_force_N.sum() / shares.sum())


def _row(loop: Loop, friction: float, of_load: Array) -> tuple[float, ...] | None:
    """Cycle, stiffness in N/µm, order and bends of a loop whose load is `of_load` (n,) times the test's."""
    x, q = loop.relative_displacement_um, loop.tangential_force_N
    share, half = min(share_of(loop, friction), _SHARES[1]), 0.5 * float(np.ptp(x))
    if not half > 0.0 or share <= 0.0:
        return None
    force = 0.5 * float(np.ptp(q))
    if share == _SHARES[1] or not (of_load == 1.0).all():
        slides_N = friction * _steady_N(loop, of_load)
        straight = share, *np.zeros(len(BENDS)).tolist()
        return loop.cycle, *yielding_of(x, q, of_load, slides_N, _orders(12), force / half), *straight
    order = 1.5
    if share > _SHARES[0]:
        # Energy over 4 Q δ, which hardly slips at all.
        shown = float(loop.friction_work_mJ[-1]) / (4e-3 * force * half)
        orders = _orders(400)
        # Energies of loops over 4 Q δ, growing with the order.
        power, left = 1.0 / orders, 1.0 - share
        inside = (1.0 - left ** (power + 1.0)) / (power + 1.0) - 0.5 * share * (1.0 + left**power)
        order = float(np.interp(shown, 2.0 * inside / (share * (1.0 - left**power)), orders))
    full = order * (1.0 - (1.0 - share) ** (1.0 / order)) / share
    return loop.cycle, full * force / half, order, share, *_bends(x, q, share, order)


def _bends(x: Array, q: Array, share: float, order: float) -> list[float]:
    """Sizes of the bends of both branches together, by least squares; `share` is the force's amplitude over friction.

    x, q: (n,) a loop in any units, whose ends the law of micro-slip meets.
    """
    ends = int(np.argmax(x)), int(np.argmin(x))
    place, force = ((one - one.min()) / np.ptp(one) for one in (x, q))
    back = (np.arange(x.size) - ends[0]) % x.size <= (ends[1] - ends[0]) % x.size
    travel, passed = (np.where(back, 1.0 - one, one) for one in (place, force))
    whole = 1.0 - (1.0 - share) ** (1.0 / order)
    missed = whole * travel - (1.0 - (1.0 - share * passed) ** (1.0 / order))
    waves = np.sin(np.pi * np.outer(passed, WAVES)) @ BENDS.T
    return [float(size) for size in np.linalg.lstsq(waves, missed, rcond=None)[0]]


def _orders(count: int) -> Array:
    return 1.0 + np.geomspace(_ORDERS[0] - 1.0, _ORDERS[1] - 1.0, count)
