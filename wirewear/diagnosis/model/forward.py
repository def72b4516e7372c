"""The fast forward model: loops and wear under any `Setup`, in milliseconds, on the wear states of one nominal run.

A loop is a chain in series: drive → play and springs → contact → sensors. The contact sticks with Mindlin's
micro-slip by Masing's rule (Johnson, Contact Mechanics, 1985, section 7.4) and slides along the force curves of its
wear state; the drive's amplitude decides how far. Worn volume follows from the loops' energies over the cycles.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from wirewear.diagnosis.model.layered_wires import SHEAR_RATIO, remembered
from wirewear.diagnosis.model.setup import Array, Setup
from wirewear.diagnosis.model.wear_states import EVEN_POWERS, LAYER_MEMORY, LIFT_POWERS, ODD_POWERS, WearStates
from wirewear.effects import Chain

#: Wear is followed over this many cycles, evenly spaced in their logarithm.
_NODES = 20

#: Sweeps of wear path against loop energy, and of slip against force; each gains a digit or more.
_WEAR_SWEEPS, _SLIP_SWEEPS = 3, 2

#: Positions on a branch: sliding, more densely towards its ends, and sticking.
_POSITIONS = np.sin(0.5 * np.pi * np.linspace(-1.0, 1.0, 41))
_STICK = np.linspace(0.0, 1.0, 48)

#: Play opens over this force, N: a step would leave a curve without an inverse.
_PLAY_FORCE_N = 0.01

#: Relative change of `SCAR_FIGURES` per retained fraction, from a simulation with 40 %: debris holds wear in place.
_CONCENTRATION = np.array([0.0, 0.5, -0.34, -0.25])

_ODD = np.stack([_POSITIONS**power for power in ODD_POWERS])
_EVEN = np.stack([_POSITIONS**power for power in EVEN_POWERS])
_LIFT = np.stack([_POSITIONS**power for power in LIFT_POWERS])
_END = _POSITIONS.size - 1

#: What is steeper towards the ends of the stroke, and what is higher there, without a mean over it.
_ENDS, _TILT = _POSITIONS**4 - 0.2, _POSITIONS**2 - 1.0 / 3.0

#: Places along a branch: the last that sticks, the first that slides, and mid-stroke.
KNEE = _STICK.size - 1
SLIDING = _STICK.size
MIDDLE = SLIDING + _POSITIONS.size // 2


@dataclass(frozen=True, eq=False)
class Course:
    """Loops and wear at some cycles (n,) under one set of circumstances, as sensors read them.

    `displacement_um` and `tangential_force_N` are (n, 2, m): the branch towards +x in order of travel, and the one
    towards −x in its own. `normal_force_N` (n, 2, m) belongs to them. `slip_um`, `energy_mJ` are those of the contact;
    `volume_um3` is that of both wires. `scars` (2, 4) are `SCAR_FIGURES` after the last cycle, by wire; `skew` is
    that of both (see `scar_skew`). `profiles` are places and depths (k,) in µm of a line contact's bodies, by name.
    """

    cycles: Array
    displacement_um: Array
    tangential_force_N: Array
    normal_force_N: Array
    slip_um: Array
    energy_mJ: Array
    volume_um3: Array
    scars: Array
    skew: float
    profiles: Mapping[str, tuple[Array, Array]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class _Contact:
    """The contact at n moments: load and force (n, m) along the branch towards +x, stiffness, order of micro-slip."""

    load_N: Array
    force_N: Array
    stiffness_N_per_um: Array
    springs_um_per_N: Array
    order: float

    @property
    def yielding_um_per_N(self) -> Array:
        """Elastic displacement (n,) per force of a contact that slides."""
        return self.order / self.stiffness_N_per_um


@dataclass(frozen=True, eq=False)
class _Layer:
    """What a rough layer changes of the contact at n moments.

    θ in rad (n, m), the logarithm of the stiffness, the compliance beyond that of a spring, the approach of the wires
    since the beginning, and the height under which the scar was worn.
    """

    theta: Array
    stiffness: Array
    springs_um_per_N: Array
    approach_um: Array
    worn_under_um: Array

    @classmethod
    def of(cls, states: WearStates, setup: Setup, chain: Chain, slip: Array) -> _Layer | None:
        """The layer of a chain from the first cycle on, at slip amplitudes (n,); None where there is none."""
        if not chain.rough_um.any() or setup.is_line:
            return None
        wires, unit = states.layered(), states.radius_um / slip**2
        under = remembered(chain.rough_um, chain.worn_um3, LAYER_MEMORY)
        similarity = states.open_share(chain) * chain.worn_um3 * unit / slip**2
        # The first moment is that before any wear.
        heights, before, worn = unit * chain.rough_um, unit * under, similarity
        found = wires.at(
            *(
                np.concatenate([one[:1], own])
                for one, own in ((heights, before), (heights, heights), (0.0 * worn, worn))
            )
        )
        slope, (stiffness, approach, closed) = found[1:, :-3], found.T[-3:]
        # Sheared by so much more than a spring of its height over the load as its mean closure is above its height.
        springs = SHEAR_RATIO * chain.rough_um * (closed[1:] - 1.0) / chain.load_N
        theta = (slip / states.radius_um)[:, None] * (slope @ _odd_hats(slope.shape[1]))
        return cls(theta, stiffness[1:], springs, (approach[1:] - approach[0]) / unit, under)

    def taken(self, moments: NDArray[np.intp]) -> _Layer:
        """Some moments only."""
        columns = self.theta, self.stiffness, self.springs_um_per_N, self.approach_um, self.worn_under_um
        return _Layer(*(column[moments] for column in columns))


def simulate(states: WearStates, setup: Setup, cycles: Array) -> Course:
    """Loops at `cycles` (n,), increasing."""
    last = max(setup.cycles, float(cycles[-1]))
    nodes = np.unique(np.concatenate([np.geomspace(0.5, last, _NODES), cycles]))
    chain, slip, energy = _wear_path(states, setup, nodes)
    at = np.searchsorted(nodes, cycles)
    layer = _Layer.of(states, setup, chain, slip)
    end, chain = chain.taken(np.array([nodes.size - 1])), chain.taken(at)
    contact = _contact(states, setup, chain, slip[at], layer and layer.taken(at))
    x, q = _branch(contact, chain, slip[at])
    x, q, p = _read(setup, chain, x, q, contact.load_N)
    return Course(
        cycles=cycles,
        displacement_um=x,
        tangential_force_N=q,
        normal_force_N=p,
        slip_um=slip[at],
        energy_mJ=energy[at],
        volume_um3=chain.worn_um3,
        scars=_scars(states, setup, end, float(slip[-1]), 0.0 if layer is None else float(layer.worn_under_um[-1])),
        skew=-float(np.tan(end.crossing_error_rad[0])),
        profiles=states.profiles(setup, end, float(slip[-1])),
    )


def _wear_path(states: WearStates, setup: Setup, cycles: Array) -> tuple[Chain, Array, Array]:
    """The chain with its worn volume, slip amplitude and loop energy at cycles (n,)."""
    steps = np.diff(cycles, prepend=0.0)
    slip = np.full_like(cycles, 0.9 * setup.amplitude_um)
    load_N = setup.load_factor * setup.load_N
    spent = 4e-6 * setup.friction * load_N * slip * cycles
    chain = setup.chain(states.radius_um, states.fresh_area_um2, cycles, spent, np.zeros_like(cycles))
    energy = 4e-3 * chain.friction * load_N * slip
    for _ in range(_WEAR_SWEEPS):
        worn, spent = _summed(np.stack([states.wearing(setup, chain, slip) * energy, 1e-3 * energy]), steps)
        if setup.follows_wear:
            chain = setup.chain(states.radius_um, states.fresh_area_um2, cycles, spent, worn)
        else:
            chain = replace(chain, energy_J=spent, worn_um3=worn)
        layer = _Layer.of(states, setup, chain, slip)
        for _ in range(_SLIP_SWEEPS):
            contact = _contact(states, setup, chain, slip, layer)
            slip = np.maximum(slip + _missing_amplitude(setup, chain, contact, slip), 0.02 * setup.amplitude_um)
        energy = _energy(contact, slip)
    return chain, slip, energy


def _summed(per_cycle: Array, steps: Array) -> Array:
    """What comes together over steps of cycles (n,), of which the first goes on as it ends; per cycle (k, n)."""
    middle = 0.5 * (per_cycle + np.concatenate([per_cycle[:, :1], per_cycle[:, :-1]], axis=1))
    return np.cumsum(middle * steps, axis=1)


def _contact(states: WearStates, setup: Setup, chain: Chain, slip: Array, layer: _Layer | None) -> _Contact:
    """The contact's force curve at a slip amplitude, from the state of equal V R/δ⁴."""
    own = setup.stretch * slip
    similarity = states.similar(states.open_share(chain) * chain.worn_um3, own)
    row, share = _places(states, similarity)
    slip_um, stiffness_N_per_um, slope, angle_rad = states.between(row, share)
    size = own / slip_um
    # Solvers agree best while the scar is shallow against the stroke, at a similarity of about one.
    decades = np.clip(np.log10(np.maximum(similarity, 1e-9)), -2.0, 2.0)
    tip = setup.tip_factor + setup.tip_trend * decades
    shape = setup.slope_factor + tip[:, None] * _ENDS
    theta = (size * np.exp(setup.slope_trend * decades))[:, None] * (slope @ _ODD) * shape
    # What slopes are stretched by says nothing of how deep the scar is.
    there = (row, share) if setup.stretch == 1.0 else _places(states, similarity * setup.stretch**4)
    drop, lift = states.loads(*there, slip)
    stiffness = setup.stick_factor * np.exp(setup.stick_trend * decades) * stiffness_N_per_um
    if chain.flattening_um.any():
        wires = states.flattened()
        # The foundation cuts walls where they are: only the run's own states are stretched.
        flat = wires.at(chain.flattening_um * states.radius_um / slip**2, similarity * setup.stretch**4)
        theta = theta + (slip / states.radius_um)[:, None] * (flat.slope @ _odd_hats(wires.positions.size))
        drop = drop + setup.normal_spring_N_per_um * flat.approach * slip**2 / states.radius_um
        stiffness = stiffness * np.exp(flat.stiffness)
    springs = chain.compliance_um_per_N
    if layer is not None:
        # As with flattening, the foundation's walls are where they are.
        theta, stiffness = theta + layer.theta, stiffness * np.exp(layer.stiffness)
        drop, springs = drop + setup.normal_spring_N_per_um * layer.approach_um, springs + layer.springs_um_per_N
    load = np.maximum(chain.load_N - drop, 0.05 * setup.load_factor * setup.load_N)
    angle = np.arctan(chain.friction)[:, None] + angle_rad @ _EVEN
    # Without a scar, all solvers agree on the same friction at every position.
    worn = np.clip((decades + 2.0) / 3.0, 0.0, 1.0)[:, None]
    angle = angle + setup.angle_tilt * worn * _TILT
    angle = angle + setup.angle_trend * np.maximum(decades, 0.0)[:, None]
    along = load[:, None] + lift @ _LIFT
    force = along * np.tan(np.clip(theta + angle, -1.2, 1.2))
    stiffness = stiffness * (load / states.normal_load_N) ** states.stiffening
    if setup.creep:
        force = force * (1.0 - setup.creep * _creeping(force, stiffness, slip))
    return _Contact(along, force, stiffness, springs, states.full_slip * float(np.exp(setup.micro_slip)))


def _creeping(force: Array, stiffness: Array, slip: Array) -> Array:
    """What is left (n, m) of a deficit in friction as the contact slides on, 1 where it begins.

    Under Dahl's law it fades over the travel that the initial stiffness takes for the whole rise from one friction to
    the other (Dahl, Aerospace Report TOR-0158, 1968); Mindlin's and Iwan's contacts have none.
    """
    length = np.maximum(force[:, _END] + force[:, 0], 1e-6) / stiffness
    return np.asarray(np.exp(-(1.0 + _POSITIONS) * (slip / length)[:, None]))


@cache
def _odd_hats(count: int) -> Array:
    """From values at so many even positions from the middle to an end to all positions (count, m): they are odd."""
    sign, at, known = np.sign(_POSITIONS), np.abs(_POSITIONS), np.linspace(0.0, 1.0, count)
    return np.stack([sign * np.interp(at, known, hat) for hat in np.eye(count)])


def _places(states: WearStates, similarity: Array) -> tuple[np.ndarray, Array]:
    """Row below each similarity and the share of the way to the next, linear in its logarithm."""
    known, wanted = states.log_similarity, np.log(similarity + states.least_similarity)
    row = np.clip(np.searchsorted(known, wanted, side="right") - 1, 0, known.size - 2)
    share = (wanted - known[row]) / (known[row + 1] - known[row])
    # Beyond the last state, the trend of the last two goes on for a while.
    return row, np.clip(share, 0.0, 3.0)


def _missing_amplitude(setup: Setup, chain: Chain, contact: _Contact, slip: Array) -> Array:
    """Asked amplitude less that of the reading (or of the true stroke) at the present slip."""
    tip = contact.force_N[:, _END]
    stroke = slip + _elastic(contact) * tip + 0.5 * chain.free_play_um
    if setup.drive == "sensor":
        at_tip = (setup.amplitude_um - chain.linear_um_per_N * tip) / chain.gain - stroke
        # A reading that leans against the force is outermost at the knee, where the force is that of the way back.
        back = contact.force_N[:, 0]
        knee = slip - _elastic(contact) * back - 0.5 * chain.free_play_um
        return np.minimum(at_tip, (setup.amplitude_um + chain.linear_um_per_N * back) / chain.gain - knee)
    return setup.amplitude_um - stroke


def _elastic(contact: _Contact) -> Array:
    """Displacement per force of a sliding contact and all springs behind it, µm/N."""
    return contact.springs_um_per_N + contact.yielding_um_per_N


def _energy(contact: _Contact, slip: Array) -> Array:
    """Friction energy of a loop in mJ: twice the work along the branch, and that of micro-slip."""
    sliding = 2.0 * slip * np.trapezoid(contact.force_N, _POSITIONS, axis=1)
    # Four times what the branch of micro-slip (`_branch`) encloses with its chord.
    share = 4.0 * (contact.order - 1.0) / (contact.order + 1.0)
    return 1e-3 * (sliding + share * contact.force_N[:, 0] ** 2 * contact.yielding_um_per_N)


def _branch(contact: _Contact, chain: Chain, slip: Array) -> tuple[Array, Array]:
    """True displacement and force (n, m) along the branch towards +x, from reversal to reversal.

    Micro-slip takes n Q/K (1 − (1 − Q/µP)^(1/n)) of travel: Mindlin's with n = 3/2, softer knees with higher orders.
    """
    force, tip = contact.force_N, contact.force_N[:, _END]
    rise = np.maximum(force[:, :1] + tip[:, None], 1e-6)
    stick = rise * _STICK - tip[:, None]
    q = np.concatenate([stick, force[:, 1:]], axis=1)
    full = contact.yielding_um_per_N[:, None]
    micro = full * rise * (1.0 - (1.0 - _STICK) ** (1.0 / contact.order)) - full * tip[:, None] - slip[:, None]
    sliding = slip[:, None] * _POSITIONS[1:] + full * force[:, 1:]
    springs = contact.springs_um_per_N[:, None]
    x = np.concatenate([micro, sliding], axis=1) + springs * q
    return x + 0.5 * chain.free_play_um[:, None] * np.clip(q / _PLAY_FORCE_N, -1.0, 1.0), q


def still_to_come(place: Array) -> Array:
    """The least place of branches (..., m) from each point on: what runs back in stick is passed again in sliding."""
    return np.asarray(np.minimum.accumulate(place[..., ::-1], axis=-1)[..., ::-1])


def _read(setup: Setup, chain: Chain, x: Array, q: Array, load: Array) -> tuple[Array, Array, Array]:
    """Both branches (n, 2, m) as the sensors read them, and the normal force; `load` (n, k) of those that slide."""
    # A branch sticks under the load of the end where it begins; the other way the load is the same, mirrored.
    there = np.concatenate([np.repeat(load[:, :1], _STICK.size, axis=1), load[:, 1:]], axis=1)
    x = np.stack([x, -x], axis=1)
    q = np.stack([q, -q], axis=1)
    p = np.stack([there, there], axis=1)
    tilt, gain, linear, quadratic, crosstalk, lag_s, force_lag_s = (
        column[:, None, None]
        for column in (
            chain.misalignment_rad,
            chain.gain,
            chain.linear_um_per_N,
            chain.quadratic_um_per_N2,
            chain.crosstalk,
            chain.lag_s,
            chain.force_lag_s,
        )
    )
    if tilt.any():
        # Q = P tan(φ ± β): climbing on one stroke, descending on the other.
        q = q + np.tan(tilt) * (p + q**2 / p)
    direction = np.array([1.0, -1.0])[:, None]
    read = gain * x + linear * q + quadratic * q**2
    if lag_s.any():
        # A drive that is a sine passes x with the speed ω sqrt(A² − x²); a filter's lag turns its phase.
        turn = np.arctan(2.0 * np.pi * setup.frequency_Hz * lag_s)
        half = 0.5 * (read.max(axis=-1, keepdims=True) - read.min(axis=-1, keepdims=True))
        read = np.cos(turn) * read - np.sin(turn) * direction * np.sqrt(np.maximum(half**2 - read**2, 0.0))
    # Measured loops are centred between their tips, whatever moves the reading as a whole.
    centre = 0.5 * (read.max(axis=(1, 2), keepdims=True) + read.min(axis=(1, 2), keepdims=True))
    q, p = q + crosstalk * p + setup.force_offset_N, p + crosstalk * q
    if force_lag_s.any():
        q = _late(q, x, 2.0 * np.pi * setup.frequency_Hz * chain.force_lag_s)
    return read - centre + setup.displacement_offset_um, q, p


def _late(q: Array, x: Array, lag: Array) -> Array:
    """Forces (n, 2, m) behind a first-order filter whose time constants (n,) are phases of a drive that is a sine.

    Between points the force goes straight; the filter's answer to that stands in closed form, and closes over a cycle.
    """
    shape = q.shape
    middle, half = 0.5 * (x.max(axis=(1, 2)) + x.min(axis=(1, 2))), 0.5 * np.ptp(x, axis=(1, 2))
    place = np.clip((x - middle[:, None, None]) / half[:, None, None], -1.0, 1.0)
    phase = np.stack([np.arcsin(place[:, 0]), np.pi - np.arcsin(place[:, 1])], axis=1).reshape(shape[0], -1)
    given, lag = q.reshape(shape[0], -1), np.maximum(lag, 1e-9)
    steps = np.maximum(np.diff(phase, axis=1, append=phase[:, :1] + 2.0 * np.pi), 1e-12)
    after = np.roll(given, -1, axis=1)
    fading = np.exp(-steps / lag[:, None])
    slope = (after - given) / steps * lag[:, None]
    # q' − (Q − λ Q̇) fades over each step; what is left after a cycle is what it began with.
    kept = np.zeros_like(given)
    passed, whole = np.zeros(shape[0]), np.ones(shape[0])
    for i in range(given.shape[1]):
        jump = slope[:, i] - slope[:, (i + 1) % given.shape[1]]
        passed, whole = passed * fading[:, i] - jump, whole * fading[:, i]
        kept[:, (i + 1) % given.shape[1]] = passed
    begin = passed / np.maximum(1.0 - whole, 1e-12)
    fade = np.concatenate([np.ones((shape[0], 1)), np.cumprod(fading[:, :-1], axis=1)], axis=1)
    kept[:, 0] = 0.0
    late: Array = (given - slope + kept + begin[:, None] * fade).reshape(shape)
    return late


def _scars(states: WearStates, setup: Setup, last: Chain, slip: float, worn_under_um: float) -> Array:
    """`SCAR_FIGURES` (2, 4) of the moving and the fixed wire at a chain's one moment, by geometric similarity."""
    volume = float(last.worn_um3[0])
    row, share = _places(states, states.similar(np.array([volume]), np.array([slip])))
    figures = states.scars[row[0]] + share[0] * (states.scars[row[0] + 1] - states.scars[row[0]])
    size = slip / float(np.interp(row[0] + share[0], np.arange(states.slip_um.size), states.slip_um))
    scaled: Array = figures * size ** np.array([4.0, 2.0, 1.0, 1.0]) * np.array([1.0, setup.scar_factor, 1.0, 1.0])
    scaled *= 1.0 + last.retained_fraction * _CONCENTRATION
    # Volumes follow the wear law exactly, whatever the similarity leaves over.
    total = scaled[:, 0].sum()
    scaled[:, 0] *= volume / total if total > 0.0 else 1.0
    if last.flattening_um.any():
        similarity = np.array([volume * states.radius_um / slip**4])
        flat = states.flattened().at(last.flattening_um * states.radius_um / np.array([slip]) ** 2, similarity)
        scaled[:, 0] += flat.volume[0] * slip**4 / states.radius_um
        scaled[:, 1] += flat.depth[0] * slip**2 / states.radius_um
        scaled[:, 2:] *= np.exp(flat.extent[0])
    if worn_under_um > 0.0:
        unit = states.radius_um / slip**2
        depth, extent = states.layered().scar(unit * worn_under_um, volume * unit / slip**2)
        scaled[:, 1] += depth / unit
        scaled[:, 2:] *= np.exp(extent)
    return scaled
