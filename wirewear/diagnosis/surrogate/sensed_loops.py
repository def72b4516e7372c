"""The loop of a contact as a rig's sensors read it, computed for both branches of n loops at once.

Arrays (n, 2, m) hold for each loop the branch towards +x, then the one back, each in order of travel; (n, k, m) the
same with k = 1 if both branches are alike. A branch sticks up to its knee and slides from there to the tip, its end.
`share` is the friction that the force reaches, 1 for contacts that slide; Masing's rule makes branches twice the first
loading.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array, ComplexArray
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.loop_states import SINE, FastMotion
from wirewear.diagnosis.surrogate.springs import PLAY_FORCE_N
from wirewear.effects import Chain

#: Positions on a branch: sliding, more densely towards its ends, and sticking.
POSITIONS = np.sin(0.5 * np.pi * np.linspace(-1.0, 1.0, 41))
STICK = np.linspace(0.0, 1.0, 48)

#: The last position, at the stroke's end; the last place that sticks, the first that slides, and mid-stroke.
END = POSITIONS.size - 1
KNEE = STICK.size - 1
SLIDING = STICK.size
MIDDLE = SLIDING + POSITIONS.size // 2

#: Even phases of a cycle on which channels are filtered: a tenth of the shortest ring's period; and its harmonics.
EVEN_PHASES: Array = 2.0 * np.pi / 1024 * np.arange(1024.0)
HARMONICS = np.arange(EVEN_PHASES.size // 2 + 1.0)

#: Bends by which a worn contact's first loading departs from its order's law: over so many half waves up to the loop's
#: ends, each without an area of its own.
BENDS, WAVES = np.array([[0.0, 1.0, 0.0, 0.0], [-1.0 / 3.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]), np.arange(1.0, 5.0)

_WAYS = np.array([[1.0], [-1.0]])  #: Of both branches, along x.

#: Of filters, complex, to harmonics of the drive.
Answers = ComplexArray


@dataclass(frozen=True, eq=False)
class SlidingContact:
    """A contact at n moments.

    load_N, force_N: (n, 1, m) normal load and friction force in each branch's direction at the sliding positions
    `POSITIONS`, under the test's load. stiffness_N_per_um: (n,) initial stiffness. springs_um_per_N: (n,) compliance of
    the springs in series. order: (n,) order of micro-slip (`sticking`).
    """

    load_N: Array
    force_N: Array
    stiffness_N_per_um: Array
    springs_um_per_N: Array
    order: Array
    share: Array  #: (n,) force reached over friction, 0 to 1; 1 if the contact slides.
    bends: Array  #: (n, 4) share at which the loop's ends lie, and sizes of its `BENDS`.

    def taken(self, moments: NDArray[np.intp]) -> "SlidingContact":
        """A copy with only those of its n moments whose indices are given, in their order."""
        return SlidingContact(*(column[moments] for column in vars(self).values()))

    @property
    def tip_N(self) -> Array:
        return np.asarray(self.force_N[..., END].mean(axis=1))

    @property
    def knee_N(self) -> Array:
        return np.asarray(self.force_N[..., 0].mean(axis=1))

    @property
    def yielding_um_per_N(self) -> Array:
        """Elastic displacement (n,) of the sliding contact over its tangential force."""
        return self.order / self.stiffness_N_per_um


def elastic_of(contact: SlidingContact) -> Array:
    """Elastic displacement (n,) in µm/N of a sliding contact and all springs in series over its tangential force."""
    return contact.springs_um_per_N + contact.yielding_um_per_N


def _waves(contact: SlidingContact) -> list[tuple[float, Array]]:
    """Half waves up to a loop's ends and their sizes (n,), by which bends change first loading; none without bends."""
    sizes = contact.bends[:, 1:]
    return [*zip(WAVES.tolist(), (sizes @ BENDS).T, strict=True)] if sizes.any() else []


def yielded(contact: SlidingContact, share: Array) -> Array:
    """Travel (n, m) over that until sliding as a contact is first loaded to these shares (n, m) of its friction."""
    travel: Array = 1.0 - (1.0 - share) ** (1.0 / contact.order[:, None])
    if waves := _waves(contact):
        at = np.pi * np.minimum(share / contact.bends[:, :1], 1.0)
        for wave, size in waves:
            travel = travel + size[:, None] * np.sin(wave * at)
    return travel


def loop_energy(contact: SlidingContact, slip: Array) -> Array:
    """Friction energy (n,) of loops in mJ, by sliding and by micro-slip; slip: (n,) largest sliding positions in µm."""
    sliding = 2.0 * slip * np.trapezoid(contact.force_N, POSITIONS, axis=2).mean(axis=1)
    # Twice what the branch of micro-slip (`branch_of`) encloses with its chord.
    power, left = 1.0 / contact.order, 1.0 - contact.share
    inside = (1.0 - left ** (power + 1.0)) / (power + 1.0) - 0.5 * contact.share * (1.0 + left**power)
    if waves := _waves(contact):
        at = np.pi * np.minimum(contact.share / contact.bends[:, 0], 1.0)
        for wave, size in waves:
            below = contact.bends[:, 0] / (np.pi * wave) * (1.0 - np.cos(wave * at))
            inside = inside + size * (0.5 * contact.share * np.sin(wave * at) - below)
    return np.asarray(1e-3 * (sliding + 8.0 * inside * contact.knee_N**2 * contact.yielding_um_per_N))


def slip_amplitude(contact: SlidingContact, slip: Array) -> Array:
    """Slip amplitude (n,) in µm as loops show it: half their width at their mean force, without the springs.

    slip: (n,) largest sliding positions in µm. If a contact slides before its force passes the mean, the width is that
    at the onset of sliding.
    """
    tip = contact.tip_N
    rise = np.maximum(contact.knee_N + tip, 1e-6)
    stuck, half = yielded(contact, np.stack([np.minimum(tip / rise, 1.0), 0.5 * contact.share], axis=1)).T
    whole = slip + contact.yielding_um_per_N * (tip - rise * stuck)
    part = micro_slip(contact) - 2.0 * contact.yielding_um_per_N * tip * half
    return np.asarray(np.where(contact.share < 1.0, part, whole))


def micro_slip(contact: SlidingContact) -> Array:
    """Half of the travel (n,) in µm, without springs, of the closed loop of a contact that sticks in its middle."""
    return np.asarray(contact.yielding_um_per_N * contact.tip_N * yielded(contact, contact.share[:, None])[:, 0])


def branches_of(contact: SlidingContact, chain: Chain, slip: Array) -> tuple[Array, Array]:
    """True displacement in µm and force in N, each (n, 2, m), along both branches from reversal to reversal.

    chain: gives the free play. slip: (n,) largest sliding positions in µm. Micro-slip takes n Q/K (1 − (1 −
    Q/µP)^(1/n)) of travel: Mindlin's with n = 3/2, softer knees with higher orders. A contact that sticks in its middle
    goes only as far along it as its `share`; the points of its sliding part then all lie at the tip.
    """
    force, share = contact.force_N, contact.share[:, None, None]
    # Each begins with the force that the other one ends with.
    tip = force[:, ::-1, END:]
    rise = np.maximum(force[..., :1] + tip, 1e-6)
    stick = share * (rise * STICK - tip)
    full, moved, sticks = contact.yielding_um_per_N[:, None, None], slip[:, None, None], share < 1.0
    before = np.where(sticks, micro_slip(contact)[:, None, None], full * tip + moved)
    micro = full * rise * yielded(contact, share[:, 0] * STICK)[:, None] - before
    q = np.concatenate([stick, np.where(sticks, stick[..., -1:], force[..., 1:])], axis=2)
    sliding = np.where(sticks, micro[..., -1:], moved * POSITIONS[1:] + full * force[..., 1:])
    x = np.concatenate([micro, sliding], axis=2) + contact.springs_um_per_N[:, None, None] * q
    x = x + 0.5 * chain.free_play_um[:, None, None] * np.minimum(np.maximum(q / PLAY_FORCE_N, -1.0), 1.0)
    return x * _WAYS, q * _WAYS


def still_to_come(place: Array) -> Array:
    """Smallest displacement (..., m) of branches at or after each point, so that it never falls along a branch."""
    return np.asarray(np.minimum.accumulate(place[..., ::-1], axis=-1)[..., ::-1])


def read_along(known: Array, values: Array, row: NDArray[np.intp], at: Array) -> Array:
    """Values (n,) of `values` (r, m) where `known` (r, m), rising along each row, is `at` (n,), linear between its
    points. row: (n,) row in which each is read. Beyond the ends of `known` the end values are taken.
    """
    count, rows = known.shape[1], np.arange(known.shape[0])
    # One search serves all branches, each lifted above the one before.
    lift = float(known.max() - known.min()) + 1.0
    inside = np.minimum(np.maximum(at, known[row, 0]), known[row, -1])
    right = np.searchsorted((known + lift * rows[:, None]).ravel(), inside + lift * row, side="right") - count * row
    right = np.minimum(np.maximum(right, 1), count - 1)
    start, first, end, last = (field[row, side] for side in (right - 1, right) for field in (known, values))
    share = np.minimum(np.maximum((inside - start) / np.maximum(end - start, 1e-12), 0.0), 1.0)
    return np.asarray(first + share * (last - first))


def loads_of(contact: SlidingContact) -> Array:
    """Normal force (n, 2, m) along both branches, as `branches_of` has their places."""
    load = contact.load_N
    # A branch sticks under the load of the end where it begins, or on the way from it to that under which it slides.
    before = load[:, ::-1, END:]
    stuck = before + STICK * (load[..., :1] - before)
    return np.repeat(np.concatenate([stuck, load[..., 1:]], axis=2), 2, axis=1)


def with_load(contact: SlidingContact, stiffening: float) -> Array:
    """Relative rise (n,) of a contact's tangential force at its tip over that of the normal force, as it is moved as
    far: 1 if it slides, `stiffening` (by which power of the load its stiffness grows) if it sticks.
    """
    share = np.clip(contact.share, 1e-9, 1.0)
    left = (1.0 - share) ** (1.0 / contact.order)
    # Of n L/K (1 − (1 − Q/L)^(1/n)) with L as the load and K as its power.
    along = contact.order * (1.0 - left) * (1.0 - share) / np.maximum(left, 1e-9) / share
    return np.asarray(1.0 - (1.0 - stiffening) * along)


def read_by_sensors(
    setup: SurrogateInputs, chain: Chain, x: Array, q: Array, p: Array, follows: Array
) -> tuple[Array, Array, Array]:
    """Displacement x, tangential force q and normal force p (n, 2, m) as sensors read n loops of two branches, from the
    true ones; follows (n,): see `with_load`.
    """
    tilt, gain, linear, quadratic, crosstalk, zero, normal_spring, moved_um = (
        np.expand_dims(column, (1, 2))
        for column in (
            chain.misalignment_rad,
            chain.gain,
            chain.linear_um_per_N,
            chain.quadratic_um_per_N2,
            chain.crosstalk,
            chain.force_zero_N + setup.force_offset_N,
            setup.normal_spring_N_per_um,
            setup.displacement_offset_um,
        )
    )
    if tilt.any():
        # A body that climbs presses the loading spring, and friction follows the load.
        holder = chain.compliance_um_per_N[:, None, None]
        relative, p = x - holder * q, np.maximum(p, PLAY_FORCE_N)
        share = 1.0 + normal_spring * np.tan(tilt) * relative / p
        p, q = share * p, share * q
        # Q = P tan(φ ± β): climbing on one stroke, descending on the other, as far as friction follows the load.
        q = q + np.tan(tilt) * (p + follows[:, None, None] * q**2 / p)
        x = relative + holder * q
    read = gain * x + linear * q + quadratic * q**2
    # A time, the same at all moments of a test, is a phase of the drive.
    for lag in np.unique(chain.lag_s[chain.lag_s != 0.0]).tolist():
        read[chain.lag_s == lag] = late_places(setup, read[chain.lag_s == lag], 2.0 * np.pi * setup.frequency_Hz * lag)
    # Measured loops are centred between their tips, whatever moves the reading as a whole.
    centre = 0.5 * (read.max(axis=(1, 2), keepdims=True) + read.min(axis=(1, 2), keepdims=True))
    q, p = q + crosstalk * p + zero, p + crosstalk * q
    if (at := np.flatnonzero(chain.force_lag_s)).size:
        q[at] = late_forces(q[at], x[at], 2.0 * np.pi * setup.frequency_Hz * chain.force_lag_s[at], setup.motion)
    return read - centre + moved_um, q, p


def late_places(setup: SurrogateInputs, read: Array, lag: float) -> Array:
    """Displacements (n, 2, m) in µm that a first-order filter reads at the moments when the true reading is `read` (n,
    2, m). setup: drive and its motion. lag: the filter's time constant times angular frequency, in rad. A sensor drive
    moves farther, by as much as the filter shrinks its stroke.
    """
    before = setup.motion.before(lag)
    after = before.behind(lag)
    phase, half = _phases_and_half(read, before)
    late = read + half * (after.at(phase) - before.at(phase)) / before.half_range
    if setup.drive == "sensor":
        late = late * (before.half_range / after.half_range)
    return np.asarray(late)


def late_forces(q: Array, x: Array, lag: Array, motion: FastMotion = SINE) -> Array:
    """Forces (n, 2, m) in N that first-order filters read of true forces q (n, 2, m) at displacements x (n, 2, m). lag:
    (n,) the filters' time constants times angular frequency, in rad. motion: of the drive, which gives the times.
    """
    delays = 1j * lag[:, None] * HARMONICS
    return q + filtered(_phases_and_half(x, motion)[0], q, -delays / (1.0 + delays))


def filtered(phases: Array, values: Array, answers: Answers) -> Array:
    """A periodic channel after filters, (n, 2, m) at the same phases. phases, values: (n, 2, m) in rad and in the
    channel's unit. answers: complex gains, (n, k) or (k,), at `HARMONICS` of the drive.
    """
    return at_phases(phases, np.fft.irfft(answers * np.fft.rfft(at_even_phases(phases, values)), EVEN_PHASES.size))


def at_even_phases(phases: Array, values: Array) -> Array:
    """A periodic channel with values (n, 2, m) at phases (n, 2, m) in rad, interpolated at `EVEN_PHASES` (n, k)."""
    pairs = zip(phases, values, strict=True)
    return np.stack([np.interp(EVEN_PHASES, at.ravel(), given.ravel(), period=2.0 * np.pi) for at, given in pairs])


def at_phases(phases: Array, evenly: Array) -> Array:
    """A channel with values `evenly` (n, k) at `EVEN_PHASES`, interpolated at phases (n, 2, m) in rad."""
    pairs = zip(phases, evenly, strict=True)
    return np.stack([np.interp(at, EVEN_PHASES, given, period=2.0 * np.pi) for at, given in pairs])


def _phases_and_half(x: Array, motion: FastMotion) -> tuple[Array, Array]:
    """When a motion passes displacements (n, 2, m), and half of its stroke (n, 1, 1)."""
    low, high = x.min(axis=(1, 2), keepdims=True), x.max(axis=(1, 2), keepdims=True)
    half = 0.5 * (high - low)
    return motion.phases((x - 0.5 * (low + high)) / half), half
