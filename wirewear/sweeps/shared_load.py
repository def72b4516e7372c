"""Runs of several contacts on one wire: how it shares the load among them as they wear.

The wire is a beam on its contacts. Each of them is a run of its own, whose approach under its load is the deflection of
the beam there; where contacts feel each other, elements of the wire with all contacts on them take the beam's place.
Loads change from block to block of cycles. They follow from runs under estimated loads: elastic approach and worn depth
of these are scaled to other loads, which the wire then shares out, until runs and wire agree. Such a round repeats
until loads change by less than 0.5 %. A contact runs only through the blocks in which it is closed. A run's approach is
that of the wire's back, of which the axis lacks a little.

A rig that gives way takes the friction of all contacts. Each run has a share of its stiffness that is the share of its
friction, so that all runs move the rig alike at the ends of the stroke.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array, BoolArray
from solvers.elasticity.bar import Bar
from wirewear.base.errors import StudyError
from wirewear.results import RunResult
from wirewear.sweeps.beam import Beam, HeldWire, Yielding, contact_forces
from wirewear.test import Study
from wirewear.test.gaps import hertz_of
from wirewear.test.many_contacts import LoadedBlock, ManyContacts

_MOST_ROUNDS = 8
#: Ends of the blocks of a test with wear, over its length: depth grows as the root of cycles, so they go by squares.
_ENDS = tuple((k / 6.0) ** 2 for k in (0.25, 1, 2, 3, 4, 5, 6))
_CLOSED = 1e-3  #: Least force of a closed contact, over the mean: less is lost beside what rounds leave open.

#: Runs of the studies of a round, by label. Called with these and the round's number, from 1.
Simulate = Callable[[Mapping[str, Study], int], Mapping[str, RunResult]]


@dataclass(frozen=True, eq=False)
class SharedLoad:
    """Shares of the load that n contacts bore in b blocks of cycles, and their runs.

    ends (b,): last cycle of each block. load_N (n, b): loads of the runs, 0 where a contact is open. approach_um (n,
    b): at mid-stroke of the blocks' last cycles, NaN where open. depth_um, volume_mm3 (n, b): largest worn depths and
    volumes of both bodies, added. runs: by label. labels: label of each contact's run, empty if the contact is
    open throughout; equal contacts share one. change: largest change of a load in the last round, over the mean load.
    """

    test: ManyContacts
    ends: tuple[int, ...]
    load_N: Array
    approach_um: Array
    depth_um: Array
    volume_mm3: Array
    runs: Mapping[str, RunResult]
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
                "worn_volume_mm3": self.volume_mm3[number, block],
            }
            for number, own in enumerate(self.test.contacts)
            for block, end in enumerate(self.ends)
        ]


def shared_load(test: ManyContacts, simulate: Simulate) -> SharedLoad:
    """The shares of the load with which runs of the contacts agree with the beam. Raises StudyError if the beam tips
    over, or if loads do not settle in eight rounds.
    """
    ends, count = _ends(test.study), len(test.contacts)
    lengths = np.diff(np.array(ends), prepend=0)
    mean = test.load_N / count
    softness = hertz_of(mean, *test.study.bodies).approach_mm / mean ** (2.0 / 3.0)
    load = _shared(test, np.full((count, len(ends)), softness), np.zeros((count, len(ends))), lengths)
    share, past = _of_sum(test.frictions[:, None] * load), []
    for rounds in range(1, _MOST_ROUNDS + 1):
        labels, studies, closed = _studies(test, load, share, lengths)
        runs = simulate(studies, rounds)
        approach, depth, volume, force = _measured([runs.get(one) for one in labels], load, lengths)
        approach = approach - test.backing_mm_per_N * load
        work = np.cumsum(load * lengths, axis=1)
        better = _shared(
            test,
            _filled((approach - depth) / np.where(closed, load, 1.0) ** (2.0 / 3.0), closed, softness),
            _filled(depth / np.sqrt(np.where(closed, work, 1.0)), closed, 0.0),
            lengths,
        )
        moved = np.abs(_of_sum(force) - share).max() if test.rig_yields else 0.0
        change = float(max(np.abs(better - load).max() / mean, moved))
        # Runs and wire agree on the loads within so much of their mean, and on the rig within so much of its travel.
        if change < 0.005:
            approach[~closed] = np.nan
            found = (1e3 * approach, 1e3 * depth, volume)
            return SharedLoad(test, ends, load, *found, runs, labels, change, rounds)
        share = _of_sum(_rubbing(test, share, load, force, better))
        load = better
        past.append(f"{100.0 * change:.2g}")
    raise StudyError(
        f"the loads of the contacts of {test.study.name} did not settle: they changed by {', '.join(past)} % of their "
        "mean from round to round; take a finer --fidelity, or a lower load or wear"
    )


def _of_sum(forces: Array) -> Array:
    """Shares (n, b) of the sum over contacts."""
    return np.asarray(forces / forces.sum(axis=0))


def _rubbing(test: ManyContacts, share: Array, load: Array, force: Array, better: Array) -> Array:
    """Friction forces (n, b) in N under loads `better`, estimated from those (`force`) under `load` with these shares
    of the rig: of contacts that slid in proportion to the load, of others by the spring that they were, whose stiffness
    goes with the radius of contact.
    """
    stated = test.study.holder.tangential_stiffness_N_per_mm
    rig = float("inf") if isinstance(stated, str) else stated
    stroke = test.strokes_mm[:, None]
    known, before = load > 0.0, np.where(load > 0.0, load, 1.0)
    # A contact that sticks in its middle carries less than its friction.
    sticks = known & (force < 0.99 * test.frictions[:, None] * load)
    most = np.where(known & ~sticks, force / before, test.frictions[:, None]) * better
    travel = force / (rig * np.where(known, share, 1.0))
    spring = np.where(sticks, force / (stroke - travel) * np.cbrt(better / before), 0.0)
    travel = np.where(sticks, spring * stroke, most).sum(axis=0) / (rig + spring.sum(axis=0))
    return np.asarray(np.where(sticks, spring * (stroke - travel), most))


def _ends(study: Study) -> tuple[int, ...]:
    cycles = study.conditions.cycles
    if study.wear is None:
        return (cycles,)
    return tuple(sorted({max(1, round(cycles * share)) for share in _ENDS}))


def _studies(
    test: ManyContacts, load: Array, share: Array, lengths: Array
) -> tuple[tuple[str, ...], dict[str, Study], BoolArray]:
    """(label of each of n contacts, studies by label, True (n, b) where it is closed); contacts with equal tables and
    loads have one study, those that stay open none. load, share: (n, b) in N, and of the friction force. lengths: (b,)
    cycles of each block.
    """
    found: dict[str, str] = {}
    labels: list[str] = []
    studies: dict[str, Study] = {}
    closed: BoolArray = load > 0.0
    for number, own in enumerate(test.contacts):
        # Equal but for round-off, as of a symmetric test.
        blocks = [
            LoadedBlock(int(lengths[k]), float(f"{load[number, k]:.11g}"), float(f"{share[number, k]:.11g}"))
            for k in np.flatnonzero(closed[number])
        ]
        key = repr((own.model_copy(update={"at_mm": 0.0, "gap_um": 0.0}), blocks))
        labels.append(found.setdefault(key, f"contact-{number + 1}") if blocks else "")
        if blocks and labels[-1] not in studies:
            studies[labels[-1]] = test.alone(number, blocks)
    return tuple(labels), studies, closed


def _measured(runs: list[RunResult | None], load: Array, lengths: Array) -> tuple[Array, Array, Array, Array]:
    """(approach in mm, worn depth in mm, worn volume in mm³, largest friction force in N), each (n, b), at the ends of
    the blocks; approach and friction are 0 where open.
    """
    approach, depth, volume, friction = (np.zeros_like(load) for _ in range(4))
    for number, run in enumerate(runs):
        done = 0
        for block, length in enumerate(lengths):
            if run is None or load[number, block] <= 0.0:
                # What is worn off stays so.
                depth[number, block] = depth[number, block - 1] if block else 0.0
                volume[number, block] = volume[number, block - 1] if block else 0.0
                continue
            done += int(length)
            # Approach of both bodies at mid-stroke of a recorded cycle.
            forces = next(one for one in run.contact_forces if one.cycle == done)
            approach[number, block] = -1e-3 * float(forces.holder_z_um[np.abs(forces.drive_um).argmin()])
            depth[number, block] = 1e-3 * _of_both(run, done, "max_depth_{}_um")
            volume[number, block] = _of_both(run, done, "worn_volume_{}_mm3")
            friction[number, block] = _at(run, done, "max_tangential_force_N")
    return approach, depth, volume, friction


def _of_both(run: RunResult, cycle: int, column: str) -> float:
    return sum(_at(run, cycle, column.format(body)) for body in run.bodies)


def _at(run: RunResult, cycle: int, column: str) -> float:
    """Value of the evolution at a measured cycle."""
    return float(run.evolution[column][np.flatnonzero(run.evolution["cycle"] == cycle)[0]])


def _filled(values: Array, known: BoolArray, default: float) -> Array:
    """A copy of values (n, b) with those that are not known taken from the contact's nearest blocks; for a contact
    without any the mean of the known ones, or `default`.
    """
    found = np.full_like(values, values[known].mean() if known.any() else default)
    blocks = np.arange(values.shape[1])
    for row, own, here in zip(found, values, known, strict=True):
        if here.any():
            row[:] = np.interp(blocks, blocks[here], own[here])
    return found


def _shared(test: ManyContacts, softness: Array, wear: Array, lengths: Array) -> Array:
    """Loads (n, b) that the beam shares out among contacts that yield so in each block (n, b), as `Yielding` says."""
    span, gap = test.span, np.array([1e-3 * own.gap_um for own in test.contacts])
    acts = test.load_N, span.loads_at_mm, span.tension_N, span.clamped_at_mm
    wire: HeldWire = Beam(test.bending_stiffness_N_mm2, test.shear_stiffness_N, *acts)
    if test.are_near:
        wire = Bar(*acts, *test.held_section)
    found, work = np.zeros_like(softness), np.zeros(len(gap))
    for block, length in enumerate(lengths):
        contacts = Yielding(gap, softness[:, block], wear[:, block], work, float(length))
        own = contact_forces(wire, test.places_mm, contacts)
        found[:, block] = np.where(own > _CLOSED * test.load_N / len(gap), own, 0.0)
        work = work + length * found[:, block]
    return found
