"""A branch of a loop from reversal to reversal: the contact sticks, then slides along its force curve."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wirewear.diagnosis.model.setup import Array
from wirewear.effects import Chain

#: Positions on a branch: sliding, more densely towards its ends, and sticking.
POSITIONS = np.sin(0.5 * np.pi * np.linspace(-1.0, 1.0, 41))
STICK = np.linspace(0.0, 1.0, 48)

#: Play opens over this force, N: a step would leave a curve without an inverse.
PLAY_FORCE_N = 0.01

#: The last position, at the stroke's end; the last place that sticks, the first that slides, and mid-stroke.
END = POSITIONS.size - 1
KNEE = STICK.size - 1
SLIDING = STICK.size
MIDDLE = SLIDING + POSITIONS.size // 2


@dataclass(frozen=True, eq=False)
class SlidingContact:
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


def elastic_of(contact: SlidingContact) -> Array:
    """Displacement per force of a sliding contact and all springs behind it, µm/N."""
    return contact.springs_um_per_N + contact.yielding_um_per_N


def loop_energy(contact: SlidingContact, slip: Array) -> Array:
    """Friction energy of a loop in mJ: twice the work along the branch, and that of micro-slip."""
    sliding = 2.0 * slip * np.trapezoid(contact.force_N, POSITIONS, axis=1)
    # Four times what the branch of micro-slip (`branch_of`) encloses with its chord.
    share = 4.0 * (contact.order - 1.0) / (contact.order + 1.0)
    return 1e-3 * (sliding + share * contact.force_N[:, 0] ** 2 * contact.yielding_um_per_N)


def branch_of(contact: SlidingContact, chain: Chain, slip: Array) -> tuple[Array, Array]:
    """True displacement and force (n, m) along the branch towards +x, from reversal to reversal.

    Micro-slip takes n Q/K (1 − (1 − Q/µP)^(1/n)) of travel: Mindlin's with n = 3/2, softer knees with higher orders.
    """
    force, tip = contact.force_N, contact.force_N[:, END]
    rise = np.maximum(force[:, :1] + tip[:, None], 1e-6)
    stick = rise * STICK - tip[:, None]
    q = np.concatenate([stick, force[:, 1:]], axis=1)
    full = contact.yielding_um_per_N[:, None]
    micro = full * rise * (1.0 - (1.0 - STICK) ** (1.0 / contact.order)) - full * tip[:, None] - slip[:, None]
    sliding = slip[:, None] * POSITIONS[1:] + full * force[:, 1:]
    springs = contact.springs_um_per_N[:, None]
    x = np.concatenate([micro, sliding], axis=1) + springs * q
    return x + 0.5 * chain.free_play_um[:, None] * np.clip(q / PLAY_FORCE_N, -1.0, 1.0), q


def still_to_come(place: Array) -> Array:
    """The least place of branches (..., m) from each point on: what runs back in stick is passed again in sliding."""
    return np.asarray(np.minimum.accumulate(place[..., ::-1], axis=-1)[..., ::-1])
