"""Runs of several contacts on one wire: how it shares the load among them as they wear.

The wire is a beam (Euler-Bernoulli) on its contacts; these are far enough apart that each is a run of its own, whose
approach under its load is the deflection of the beam there. Loads change from block to block of cycles. They follow
from runs under estimated loads: elastic approach and worn depth of these are scaled to other loads, which the beam then
shares out, until runs and beam agree. Such a round repeats until loads change by less than 0.5 %.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array
from wirewear.base.errors import StudyError
from wirewear.results import RunResult
from wirewear.test import Study
from wirewear.test.bodies import hertz_of
from wirewear.test.many_contacts import ManyContacts

_MOST_ROUNDS = 6
_BLOCKS = 6  #: Of a test with wear: depth grows as the root of cycles, so their ends go with the square.

Simulate = Callable[[Study, str], RunResult]  #: Run a study under a label.


@dataclass(frozen=True, eq=False)
class SharedLoad:
    """Shares of the load that n contacts bore in b blocks of cycles, and their runs.

    ends (b,): last cycle of each block. load_N (n, b): loads of the runs. approach_um (n, b): at mid-stroke of the
    blocks' last cycles. depth_um (n, b): largest worn depths of both bodies, added. runs, labels: of each contact;
    equal contacts have the same. change: largest change of a load in the last round, over the mean load.
    """

    test: ManyContacts
    ends: tuple[int, ...]
    load_N: Array
    approach_um: Array
    depth_um: Array
    runs: tuple[RunResult, ...]
    labels: tuple[str, ...]
    change: float
    rounds: int

    @property
    def rows(self) -> list[dict[str, float]]:
        """A row, by column, for each contact and block: load, approach, worn depth and worn volume at its end."""
        return [
            {
                "contact": number + 1,
                "at_mm": own.at_mm,
                "cycle": end,
                "normal_load_N": self.load_N[number, block],
                "approach_um": self.approach_um[number, block],
                "worn_depth_um": self.depth_um[number, block],
                "worn_volume_mm3": volume_mm3(self.runs[number], end),
            }
            for number, own in enumerate(self.test.contacts)
            for block, end in enumerate(self.ends)
        ]


def shared_load(test: ManyContacts, simulate: Simulate) -> SharedLoad:
    """The shares of the load with which runs of the contacts agree with the beam. simulate: runs a study under a label.
    Raises StudyError if a contact lifts off, or if loads do not settle in six rounds.
    """
    ends, count = _ends(test.study), len(test.contacts)
    lengths = np.diff(np.array(ends, dtype=np.float64), prepend=0.0)
    hertz = hertz_of(test.load_N / count, *test.study.bodies).approach_mm
    load = np.full((count, len(ends)), test.load_N / count)
    load, past = _shared(test, load, np.full_like(load, hertz), np.zeros_like(load), lengths), []
    for rounds in range(1, _MOST_ROUNDS + 1):
        runs, labels = _simulated(test, load, lengths, simulate)
        approach = np.array([[_approach_mm(run, end) for end in ends] for run in runs])
        depth = np.array([[_depth_mm(run, end) for end in ends] for run in runs])
        better = _shared(test, load, approach - depth, depth, lengths)
        change = float(np.abs(better - load).max() / load.mean())
        # Runs and beam agree on the loads within so much of their mean.
        if change < 0.005:
            return SharedLoad(test, ends, load, 1e3 * approach, 1e3 * depth, runs, labels, change, rounds)
        load = better
        past.append(f"{100.0 * change:.2g}")
    raise StudyError(
        f"the loads of the contacts of {test.study.name} did not settle: they changed by {', '.join(past)} % of their "
        "mean from round to round; take a finer --fidelity, or a lower load or wear"
    )


def _ends(study: Study) -> tuple[int, ...]:
    cycles = study.conditions.cycles
    if study.wear is None:
        return (cycles,)
    return tuple(sorted({max(1, round(cycles * (k / _BLOCKS) ** 2)) for k in range(1, _BLOCKS + 1)}))


def _simulated(
    test: ManyContacts, load: Array, lengths: Array, simulate: Simulate
) -> tuple[tuple[RunResult, ...], tuple[str, ...]]:
    """Runs of all contacts, and their labels; those with equal tables and loads are run once."""
    found: dict[str, tuple[RunResult, str]] = {}
    keys = []
    for number, own in enumerate(test.contacts):
        # Equal but for round-off, as of a symmetric test.
        blocks = [(int(cycles), float(f"{each:.11g}")) for cycles, each in zip(lengths, load[number], strict=True)]
        keys.append(repr((own.model_copy(update={"at_mm": 0.0}), blocks)))
        if keys[-1] not in found:
            label = f"contact-{number + 1}"
            found[keys[-1]] = simulate(test.alone(number, blocks), label), label
    runs, labels = zip(*(found[key] for key in keys), strict=True)
    return runs, labels


def _approach_mm(run: RunResult, cycle: int) -> float:
    """Approach of both bodies at mid-stroke of a recorded cycle."""
    forces = next(one for one in run.contact_forces if one.cycle == cycle)
    return -1e-3 * float(forces.holder_z_um[np.abs(forces.drive_um).argmin()])


def _depth_mm(run: RunResult, cycle: int) -> float:
    return 1e-3 * _of_both(run, cycle, "max_depth_{}_um")


def volume_mm3(run: RunResult, cycle: int) -> float:
    """Worn volume of both bodies after `cycle` cycles, which must be a measured one."""
    return _of_both(run, cycle, "worn_volume_{}_mm3")


def _of_both(run: RunResult, cycle: int, column: str) -> float:
    row = int(np.flatnonzero(run.evolution["cycle"] == cycle)[0])
    return float(sum(run.evolution[column.format(body)][row] for body in run.bodies))


def _shared(test: ManyContacts, load: Array, elastic_mm: Array, worn_mm: Array, lengths: Array) -> Array:
    """Loads (n, b) that the beam shares out, from runs under loads (n, b) with their elastic and worn approaches."""
    found = np.zeros_like(load)
    before = np.cumsum(load * lengths, axis=1)
    for block in range(load.shape[1]):
        start = found[:, :block] @ lengths[:block]

        def approach(own: Array, block: int = block, start: Array = start) -> Array:
            # Elastic approach goes with the load's power 2/3, a scar's depth with the root of its volume.
            share = np.maximum(own, 0.0) / load[:, block]
            grown = np.maximum(start + own * lengths[block], 0.0) / before[:, block]
            return np.asarray(elastic_mm[:, block] * share ** (2.0 / 3.0) + worn_mm[:, block] * np.sqrt(grown))

        found[:, block] = beam_loads(
            test.places_mm, test.load_N, test.loads_at_mm, test.bending_stiffness_N_mm2, approach, load[:, block]
        )
        if (lifted := np.flatnonzero(found[:, block] <= 1e-3 * load.mean())).size:
            raise StudyError(
                f"contact {lifted[0] + 1} of {test.study.name} lifts off, so that it carries no load: leave it out, or "
                "move it or the load"
            )
    return found


def beam_loads(
    places_mm: Array,
    load_N: float,
    loads_at_mm: tuple[float, ...],
    bending_stiffness_N_mm2: float,
    approach_mm: Callable[[Array], Array],
    start_N: Array,
) -> Array:
    """Forces (n,) in N on a free beam at its supports `places_mm` (n,), which yield by `approach_mm` of these forces
    (n,) in mm.

    load_N acts in equal parts at `loads_at_mm`; start_N (n,): first guess. The beam's deflection is a rigid motion and
    that of a force in an endless beam, |x - s|³/12EI, summed over loads and forces, which are in equilibrium. Raises
    StudyError if none is found.
    """
    from scipy.optimize import root

    at, each = np.array(loads_at_mm), load_N / len(loads_at_mm)

    def bent(ends: Array) -> Array:
        return np.asarray(np.abs(places_mm[:, None] - ends) ** 3 / (12.0 * bending_stiffness_N_mm2))

    by_load, by_force = each * bent(at).sum(axis=1), bent(places_mm)
    size = float(np.abs(approach_mm(start_N)).max())
    span = float(np.ptp(places_mm))

    def missed(unknowns: Array) -> Array:
        force, (sunk, tilt) = unknowns[:-2] * load_N, unknowns[-2:] * size
        beam = sunk + tilt * places_mm / span + by_load - by_force @ force
        balance = [force.sum() - load_N, (force @ places_mm - each * at.sum()) / span]
        return np.concatenate([(beam - approach_mm(force)) / size, np.array(balance) / load_N])

    found = root(missed, np.concatenate([start_N / load_N, [1.0, 0.0]]), method="hybr", options={"xtol": 1e-13})
    if np.abs(missed(found.x)).max() > 1e-9:
        raise StudyError("no loads were found under which the wire rests on its contacts; please report this study")
    return np.asarray(found.x[:-2] * load_N)
