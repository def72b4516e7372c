"""The fast forward model: loops and wear under any inputs, in milliseconds, from the wear states of one nominal run.

Several setups (inputs of the fast model) are computed together: arrays hold their moments one after the other, as many
for each. A loop is a chain in series: drive → play and springs → contact → sensors. The contact sticks with Mindlin's
micro-slip by Masing's rule (Johnson, Contact Mechanics, 1985, section 7.4) and slides along the force curves of its
wear state; the drive's amplitude decides how far. Worn volume follows from the loops' energies over the cycles.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array
from wirewear.diagnosis.surrogate import sensed_loops
from wirewear.diagnosis.surrogate.control import LEAST_SLIP, driven, half_reading, missing_of
from wirewear.diagnosis.surrogate.inputs import NUMBERS, SurrogateInputs
from wirewear.diagnosis.surrogate.layered_wires import LAYER_MEMORY, SHEAR_RATIO, FlattenedWires, remembered
from wirewear.diagnosis.surrogate.loop_states import EVEN_POWERS, LIFT_POWERS, ODD_POWERS
from wirewear.diagnosis.surrogate.sticking import worn_as_far
from wirewear.diagnosis.surrogate.varying_load import CyclePath, Followed, followed
from wirewear.diagnosis.surrogate.wear_states import WearStates
from wirewear.effects import Chain

#: Sweeps of wear path against loop energy, and of slip against force; each gains a digit or more.
_WEAR_SWEEPS, _SLIP_SWEEPS = 3, 2


#: Orders of micro-slip beyond this one are as good as an exponential, of which sliding would never begin.
HIGHEST_ORDER = 16.0

#: Relative change of `SCAR_FIGURES` per retained fraction, from a simulation with 40 %: debris holds wear in place.
_CONCENTRATION = np.array([0.0, 0.5, -0.34, -0.25])

_ODD = np.stack([sensed_loops.POSITIONS**power for power in ODD_POWERS])
_EVEN = np.stack([sensed_loops.POSITIONS**power for power in EVEN_POWERS])
_LIFT = np.stack([sensed_loops.POSITIONS**power for power in LIFT_POWERS])


#: What is steeper towards the ends of the stroke, without a mean over it.
_ENDS = sensed_loops.POSITIONS**4 - 0.2


#: Columns of what is predicted that are of its loops.
OF_LOOPS = "displacement_um", "tangential_force_N", "normal_force_N", "slip_um", "energy_mJ", "volume_um3"


@dataclass(frozen=True, eq=False)
class PredictedLoops:
    """Loops and wear at n cycles under one set of inputs, as sensors read them.

    displacement_um, tangential_force_N, normal_force_N: (n, 2, m), the branch towards +x and then the one back, each in
    order of travel. slip_um, energy_mJ: (n,) of the contact. volume_um3: (n,) worn off both bodies. scars: (2, 4)
    `SCAR_FIGURES` after the last cycle, by body; skew: (2,) of these scars, see `scar_skew`. profiles: positions and
    depths (k,) in µm of a line contact's bodies, by name.
    """

    cycles: Array
    displacement_um: Array
    tangential_force_N: Array
    normal_force_N: Array
    slip_um: Array
    energy_mJ: Array
    volume_um3: Array
    scars: Array
    skew: Array
    profiles: Mapping[str, tuple[Array, Array]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class _Layer:
    """What a layer that spreads the pressure changes of the contact at n moments.

    θ in rad (n, m), the logarithm of the stiffness, the compliance beyond that of a spring, the approach of the wires
    since the beginning, and the height under which the scar was worn.
    """

    theta: Array
    stiffness: Array
    springs_um_per_N: Array
    approach_um: Array
    worn_under_um: Array

    @classmethod
    def of(cls, states: WearStates, chain: Chain, slip: Array) -> _Layer | None:
        """The layer of a chain from the first cycle on, at slip amplitudes (n,); None where there is none."""
        spread_um = chain.rough_um + chain.bed_um
        if states.sticks or not (spread_um.any() and states.has_layers):
            return None
        wires, unit = states.layered(), states.radius_um / slip**2
        under = remembered(spread_um, chain.worn_um3, LAYER_MEMORY)
        similarity = states.open_share(chain) * chain.worn_um3 * unit / slip**2
        heights, before, fresh = unit * spread_um, unit * under, unit * spread_um[0]
        found = wires.at(before, heights, similarity)
        slope, (stiffness, approach, closed) = found[:, :-3], found.T[-3:]
        # The table holds for the nominal slip: that of another one is seen against fresh wires of as much slip.
        since = approach - wires.at(fresh, fresh, np.zeros_like(unit))[:, -2]
        # Sheared by so much more than a spring of the asperities' height over the load as the mean closure is above it.
        springs = SHEAR_RATIO * chain.rough_um * (closed - 1.0) / chain.load_N
        theta = (slip / states.radius_um)[:, None] * (slope @ _odd_hats(slope.shape[1]))
        return cls(theta, stiffness, springs, since / unit, under)

    @classmethod
    def of_all(cls, states: WearStates, chains: Sequence[Chain], slip: Array) -> _Layer | None:
        """Layers of several chains in rows; zeros where one has none, None where none has one."""
        found = [cls.of(states, *own) for own in zip(chains, np.split(slip, len(chains)), strict=True)]
        known = next((layer for layer in found if layer is not None), None)
        if known is None:
            return None
        nothing = _Layer(*(np.zeros_like(column) for column in known.columns))
        return _Layer(*map(np.concatenate, zip(*((layer or nothing).columns for layer in found), strict=True)))

    @property
    def columns(self) -> tuple[Array, ...]:
        return self.theta, self.stiffness, self.springs_um_per_N, self.approach_um, self.worn_under_um

    def taken(self, moments: NDArray[np.intp]) -> _Layer:
        """The moments of these indices only."""
        return _Layer(*(column[moments] for column in self.columns))


def simulate(states: WearStates, setup: SurrogateInputs, cycles: Array) -> PredictedLoops:
    """Loops that the fast model predicts at increasing `cycles` (n,), from wear states under the inputs `setup`."""
    return simulated(states, (setup,), cycles)[0]


def simulated(states: WearStates, setups: Sequence[SurrogateInputs], cycles: Array) -> list[PredictedLoops]:
    """Loops at increasing `cycles` (n,) under each of several setups, which may differ in effects and numbers, but not
    in the test and what its drive holds.
    """
    in_time = [setup.in_time for setup in setups]
    if len(set(in_time)) > 1:
        # Each as it is computed alone: an effect is judged by differences.
        kinds = {kind: [one for one, own in zip(setups, in_time, strict=True) if own is kind] for kind in (False, True)}
        found = {kind: iter(simulated(states, own, cycles)) for kind, own in kinds.items()}
        return [next(found[kind]) for kind in in_time]
    last = max(setups[0].cycles, float(cycles[-1]))
    # Wear is followed over this many cycles, evenly spaced in their logarithm.
    nodes = np.unique(np.concatenate([np.geomspace(0.5, last, 20) if states.wears else [last], cycles]))
    chains, slip, swept, energy, share = _wear_path(states, setups, nodes)
    layer = _Layer.of_all(states, chains, swept)
    first = nodes.size * np.arange(len(setups))
    at, ends = (first[:, None] + np.searchsorted(nodes, cycles)).ravel(), first + nodes.size - 1
    whole, setup = Chain.joined(chains), _columns(setups, cycles.size)
    chain, end = whole.taken(at), whole.taken(ends)
    contact = _contact_at_slip(states, setup, chain, swept[at], layer and layer.taken(at), share[at])
    contact = replace(contact, share=share[at])
    if not in_time[0]:
        true = *sensed_loops.branches_of(contact, chain, slip[at]), sensed_loops.loads_of(contact)
    else:
        own = _followed(setup, chain, contact, slip[at])
        true = own.displacement_um, own.force_N, own.load_N
    loops = sensed_loops.read_by_sensors(setup, chain, *true, sensed_loops.with_load(contact, states.stiffening))
    under = np.zeros(len(setups)) if layer is None else layer.worn_under_um[ends]
    reach = states.reach(np.maximum(swept[ends], [LEAST_SLIP * one.amplitude_um for one in setups]))
    stated_um = np.array([one.print_um for one in setups])
    scars, skews = _scars(states, end, reach, under, stated_um), _skews(states, end, reach)
    profiles = [
        states.profiles(one, end.taken(np.array([place])), float(reach[place]), float(share[ends[place]]))
        for place, one in enumerate(setups)
    ]
    columns = (np.split(column, len(setups)) for column in (*loops, slip[at], energy[at], chain.worn_um3))
    return [PredictedLoops(cycles, *own) for own in zip(*columns, scars, skews, profiles, strict=True)]


def _columns(setups: Sequence[SurrogateInputs], moments: int) -> SurrogateInputs:
    """Several setups as one whose numbers are arrays (n,), one for each of so many moments of each."""
    each: dict[str, Any] = {name: np.repeat([getattr(setup, name) for setup in setups], moments) for name in NUMBERS}
    return replace(setups[0], **each)


def _wear_path(
    states: WearStates, setups: Sequence[SurrogateInputs], cycles: Array
) -> tuple[list[Chain], Array, Array, Array, Array]:
    """Each setup's chain with its worn volume at cycles (n,), and slip amplitudes, amplitudes over which scars are
    swept, loop energies and shares of the friction that are reached, of all, joined.
    """
    count, setup = len(setups), _columns(setups, cycles.size)
    wearing = setups[0].wearing_cycles(cycles)
    steps = np.diff(wearing, prepend=0.0)
    slip, load_N = np.asarray(0.9 * setup.amplitude_um), setup.load_factor * setup.load_N
    spent = 4e-6 * setup.friction * load_N * slip * np.tile(wearing, count)
    circumstances = states.spot_radius_um, states.fresh_area_um2, cycles
    chains = [
        one.chain(*circumstances, own, np.zeros_like(cycles))
        for one, own in zip(setups, np.split(spent, count), strict=True)
    ]
    energy = 4e-3 * np.concatenate([chain.friction for chain in chains]) * load_N * slip
    swept, share = slip, np.full(slip.size, states.yields[0, 1] if states.sticks else 1.0)
    # Where nothing wears, a cycle that is followed is as it is at once.
    for _ in range(_WEAR_SWEEPS if states.wears or setup.load_cycle.steady else 1):
        each = zip(setups, chains, np.split(swept, count), strict=True)
        faster = np.concatenate([states.wearing(*own) for own in each])
        # What comes together over steps of cycles (n,), of which the first goes on as it ends; per cycle (..., n).
        per_cycle = np.stack([faster * energy, 1e-3 * energy]).reshape(2, count, -1)
        middle = 0.5 * (per_cycle + np.concatenate([per_cycle[..., :1], per_cycle[..., :-1]], axis=-1))
        worn, spent = np.cumsum(middle * steps, axis=-1)
        chains = [
            one.chain(*circumstances, own, lost) if one.follows_wear else replace(chain, energy_J=own, worn_um3=lost)
            for one, chain, own, lost in zip(setups, chains, spent, worn, strict=True)
        ]
        layer, chain = _Layer.of_all(states, chains, swept), Chain.joined(chains)
        for _ in range(_SLIP_SWEEPS if setup.load_cycle.steady else 1):
            contact = _contact_at_slip(states, setup, chain, swept, layer, share)
            # What a swinging holder changes of slip goes with the square of the ratio of both frequencies.
            if setup.load_cycle.steady:
                slip, share = driven(setup, chain, contact, slip)
                energy = sensed_loops.loop_energy(replace(contact, share=share), slip)
                swept = slip if states.sticks else _swept(states, setup, replace(contact, share=share), slip)
            else:
                found = _followed(setup, chain, contact, slip)
                slip, share, energy = found.slip_um, found.share, found.energy_mJ
                swept = slip
    return chains, slip, swept, energy, share


def _swept(states: WearStates, setup: SurrogateInputs, contact: sensed_loops.SlidingContact, slip: Array) -> Array:
    """Amplitudes (n,) in µm over which surfaces sweep one another: their motion less what bodies yield by the run's own
    order of micro-slip. A higher order sticks longer, but moves the bodies no less.
    """
    yielded = contact.yielding_um_per_N * contact.tip_N
    moved = np.where(contact.share < 1.0, sensed_loops.micro_slip(contact) - contact.share * yielded, slip)
    more = contact.share * yielded * (1.0 - states.full_slip / contact.order)
    return np.asarray(np.maximum(moved + more, LEAST_SLIP * setup.amplitude_um))


def _contact_at_slip(
    states: WearStates, setup: SurrogateInputs, chain: Chain, slip: Array, layer: _Layer | None, reached: Array
) -> sensed_loops.SlidingContact:
    """The contact's force curve at a slip amplitude, from the state of equal V R/δ⁴; reached: share of its friction."""
    slip = states.reach(np.maximum(slip, LEAST_SLIP * setup.amplitude_um))
    own = setup.stretch * slip
    similarity = states.similar(states.open_share(chain) * chain.worn_um3, own)
    row, share = _places(states, similarity)
    for _ in range(_SLIP_SWEEPS * states.sticks):
        run = states.yielding_between(row, share)[:, 1]
        row, share = _places(states, similarity * worn_as_far(reached, run))
    slip_um, stiffness_N_per_um, slope, angle_rad = states.between(row, share)
    size = own / slip_um
    # Solvers agree best while the scar is shallow against the stroke, at a similarity of about one.
    decades = np.log10(np.minimum(np.maximum(similarity, 1e-2), 1e2))
    tip = setup.tip_factor + setup.tip_trend * decades
    shape = np.expand_dims(setup.slope_factor, 1) + tip[:, None] * _ENDS
    theta = size[:, None] * (slope @ _ODD) * shape
    # What slopes are stretched by says nothing of how deep the scar is.
    unstretched = similarity * setup.stretch**4
    drop, lift = states.loads(*_places(states, unstretched), slip)
    stiffness = setup.stick_factor * np.exp(setup.stick_trend * decades) * stiffness_N_per_um
    for at, wires, *approaches in _flats(states, chain, np.asarray(setup.print_um)):
        unit = slip[at] ** 2 / states.radius_um
        # The foundation cuts walls where they are: only the run's own states are stretched.
        flat = wires.at(*(one / unit for one in approaches), similarity=unstretched[at])
        theta[at] += (slip[at] / states.radius_um)[:, None] * (flat.slope @ _odd_hats(wires.positions.size))
        drop[at] += np.take(setup.normal_spring_N_per_um, at) * flat.approach * unit
        stiffness[at] *= np.exp(flat.stiffness)
    springs = chain.compliance_um_per_N
    if layer is not None:
        # As with flattening, the foundation's walls are where they are.
        theta, stiffness = theta + layer.theta, stiffness * np.exp(layer.stiffness)
        drop, springs = drop + setup.normal_spring_N_per_um * layer.approach_um, springs + layer.springs_um_per_N
    load = np.maximum(chain.load_N - drop, 0.05 * setup.load_factor * setup.load_N)
    friction = chain.friction * states.friction_between(row, share)
    angle = np.arctan(friction)[:, None] + np.expand_dims(setup.angle_rise, 1) * (angle_rad @ _EVEN)
    along = (load[:, None] + lift @ _LIFT)[:, None]
    ratio = np.tan(np.minimum(np.maximum(theta + angle, -1.2), 1.2))[:, None]
    stiffness = stiffness * (load / states.normal_load_N) ** states.stiffening
    yields = states.yielding_between(row, share)
    order, bends = yields[:, 0], yields[:, 1:]
    # Micro-slip works as n − 1, which is known as well where a body gives way as a whole, with an order near one.
    less = np.minimum(3.0 * (1.0 - 1.0 / order), 1.0) if states.sticks else 1.0
    order = np.minimum(order * np.exp(less * setup.micro_slip), HIGHEST_ORDER)
    bends[:, 0] = reached
    return sensed_loops.SlidingContact(along, along * ratio, stiffness, springs, order, np.ones_like(stiffness), bends)


def _flats(
    states: WearStates, chain: Chain, stated_um: Array
) -> Iterator[tuple[NDArray[np.intp], FlattenedWires, Array, Array]]:
    """Moments (n,) at which bodies have other flats than in the nominal run, the table of their changes, and the
    approaches (n,) in µm of both. stated_um: of the nominal run's prints.
    """
    imposed, printed = (chain.flattening_um, np.zeros_like(chain.load_N)), (chain.print_um, stated_um)
    for slid, (own, stated) in enumerate((imposed, printed)):
        if not states.sticks and (at := np.flatnonzero(own != stated)).size:
            yield at, states.flattened(slid=bool(slid)), own[at], stated[at]


@cache
def _odd_hats(count: int) -> Array:
    """From values at so many even positions from the middle to an end to all positions (count, m): they are odd."""
    sign, at, known = np.sign(sensed_loops.POSITIONS), np.abs(sensed_loops.POSITIONS), np.linspace(0.0, 1.0, count)
    return np.stack([sign * np.interp(at, known, hat) for hat in np.eye(count)])


def _places(states: WearStates, similarity: Array) -> tuple[np.ndarray, Array]:
    """Row below each similarity and the share of the way to the next, linear in its logarithm."""
    known, wanted = states.log_similarity, np.log(similarity + states.least_similarity)
    row = np.minimum(np.maximum(np.searchsorted(known, wanted, side="right") - 1, 0), known.size - 2)
    share = (wanted - known[row]) / (known[row + 1] - known[row])
    # Beyond the last state, the trend of the last two goes on for a while.
    return row, np.minimum(np.maximum(share, 0.0), 3.0)


def _followed(setup: SurrogateInputs, chain: Chain, contact: sensed_loops.SlidingContact, slip: Array) -> Followed:
    """The cycle under a load that varies, by which a drive holds what it holds."""
    path = CyclePath.of(setup.motion, setup.load_cycle, swings=bool(chain.mass_kg.any()))
    slip = np.maximum(slip, LEAST_SLIP * setup.amplitude_um)
    held, stroke = bool(setup.held) & np.isnan(chain.amplitude_um), np.array(chain.amplitude_um)
    stroke[held] = np.asarray(setup.amplitude_um)[held]
    reads = setup.drive == "sensor" and not setup.held
    target = np.where(held, setup.held_share * setup.amplitude_um, chain.amplitude_um)
    if reads:
        stroke = stroke / chain.gain
    found = followed(contact, chain, path, slip, stroke, setup.frequency_Hz)
    # Sweeps of a stroke against what a drive holds in place of it, of those contacts that miss it.
    for _ in range(3 if reads or held.any() else 0):
        if reads:
            missing = (target - half_reading(chain, found.displacement_um, found.force_N)) / chain.gain
        else:
            missing = np.where(held, missing_of(setup, chain, contact, found, target), 0.0)
        at = np.flatnonzero(np.abs(missing) > 1e-9 * stroke)
        if not at.size:
            break
        stroke[at] += missing[at]
        again = followed(contact.taken(at), chain.taken(at), path, slip[at], stroke[at], setup.frequency_Hz)
        for name, column in vars(again).items():
            getattr(found, name)[at] = column
    return found


def _scars(states: WearStates, last: Chain, slip: Array, worn_under_um: Array, stated_um: Array) -> Array:
    """`SCAR_FIGURES` (k, 2, 4) of the moving and the fixed wire at a chain's moments (k,), by geometric similarity.
    stated_um: (k,) of the nominal run's prints.
    """
    similar, (known, slips) = states.similar(last.worn_um3, slip), states.of_scars
    at, among = (np.log(one + states.least_similarity) for one in (similar, known))
    place = np.interp(at, among, np.arange(known.size))
    row = np.minimum(place.astype(int), known.size - 2)
    share = (place - row)[:, None, None]
    figures = states.scars[row] + share * (states.scars[row + 1] - states.scars[row])
    figures *= np.maximum(similar / known[-1], 1.0)[:, None, None] ** states.scars_growth
    size = slip / np.interp(place, np.arange(known.size), slips)
    scaled: Array = figures * size[:, None, None] ** np.array([4.0, 2.0, 1.0, 1.0])
    scaled *= 1.0 + last.retained_fraction[:, None, None] * _CONCENTRATION
    # Volumes follow the wear law exactly, whatever the similarity leaves over.
    total = scaled[:, :, 0].sum(axis=1)
    scaled[:, :, 0] *= np.divide(last.worn_um3, total, out=np.ones_like(total), where=total > 0.0)[:, None]
    unit = states.radius_um / slip**2
    similarity = last.worn_um3 * unit / slip**2
    for at, wires, *approaches in _flats(states, last, stated_um):
        flat = wires.at(*(one * unit[at] for one in approaches), similarity=similarity[at])
        scaled[at, :, 0] += flat.volume * (slip[at] ** 2 / unit[at])[:, None]
        scaled[at, :, 1] += flat.depth / unit[at, None]
        scaled[at, :, 2:] *= np.exp(flat.extent)
    for one in np.flatnonzero(worn_under_um > 0.0).tolist():
        depth, extent = states.layered().scar(float(unit[one] * worn_under_um[one]), float(similarity[one]))
        scaled[one, :, 1] += depth / unit[one]
        scaled[one, :, 2:] *= np.exp(extent)
    return scaled


def _skews(states: WearStates, last: Chain, slip: Array) -> Array:
    """Skews (k, 2) of both wires' scars: sheared by the crossing angle as it is, the rest the run's."""
    at, known = (
        np.log(one + states.least_similarity) for one in (states.similar(last.worn_um3, slip), states.of_scars[0])
    )
    beyond = np.broadcast_to(states.extra_skew, (known.size, 2)).T
    own = np.stack([np.interp(at, known, one) for one in beyond], axis=1)
    return np.asarray(own - np.tan(last.crossing_error_rad)[:, None])
