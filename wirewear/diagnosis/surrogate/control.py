"""The slip by which a drive holds what it holds: a stroke, its own or its sensor's, or a figure of the loop instead."""

from dataclasses import replace
from typing import Any

import numpy as np

from geometry.arrays import Array
from wirewear.diagnosis.surrogate import sensed_loops
from wirewear.diagnosis.surrogate.inputs import NUMBERS, SurrogateInputs
from wirewear.diagnosis.surrogate.sensed_loops import SlidingContact
from wirewear.diagnosis.surrogate.varying_load import Followed
from wirewear.effects import Chain

#: Contacts that slide less than this share of the amplitude stick in their middle; halvings of what is reached.
LEAST_SLIP, _HALVINGS = 0.02, 32


def driven(setup: SurrogateInputs, chain: Chain, contact: SlidingContact, slip: Array) -> tuple[Array, Array]:
    """Slip amplitudes (n,) by which a drive holds what it holds, and shares (n,) of the friction that are reached."""
    share, least = np.ones_like(slip), LEAST_SLIP * setup.amplitude_um
    wanted = slip + _missing_slip(setup, chain, contact, slip)
    if (at := np.flatnonzero(wanted < least)).size:
        numbers: dict[str, Any] = {name: np.take(getattr(setup, name), at) for name in NUMBERS}
        share[at] = _sticking_share(replace(setup, **numbers), chain.taken(at), contact.taken(at))
    return np.where(share < 1.0, 0.0, np.maximum(wanted, 0.0)), share


def missing_of(setup: SurrogateInputs, chain: Chain, contact: SlidingContact, found: Followed, target: Array) -> Array:
    """Distance (n,) by which a drive has to move farther for cycles to have the figure that it holds in place of a
    stroke.
    """
    force = 0.5 * np.ptp(found.force_N, axis=(1, 2))
    if setup.held == "tangential":
        return np.asarray((target - force) * (contact.springs_um_per_N + 1.0 / contact.stiffness_N_per_um))
    if setup.held == "energy":
        return (target - found.energy_mJ) / (4e-3 * contact.tip_N)
    if setup.held == "motion":
        stroke = 0.5 * np.ptp(found.displacement_um, axis=(1, 2))
        return np.asarray(target - stroke + chain.compliance_um_per_N * force + 0.5 * chain.free_play_um)
    return target - found.slip_um


def _sticking_share(setup: SurrogateInputs, chain: Chain, contact: SlidingContact) -> Array:
    """Share (n,) of the friction with which a contact that sticks in its middle holds what a drive holds; one where it
    slides. By bisection: all that is held grows with it.
    """
    # Beside those that hold a figure of the loop there may be drives that an effect makes hold their stroke.
    tip, held = contact.tip_N, bool(setup.held) & np.isnan(chain.amplitude_um)
    target = np.where(held, setup.held_share * setup.amplitude_um, chain.amplitude_um)
    gain, coupling = (chain.gain, chain.linear_um_per_N) if setup.drive == "sensor" and not setup.held else (1.0, 0.0)

    def reached(share: Array) -> Array:
        own, force = replace(contact, share=share), share * tip
        moved = sensed_loops.micro_slip(own) + contact.springs_um_per_N * force
        stroke = gain * (moved + 0.5 * chain.free_play_um) + coupling * force
        if setup.held == "energy":
            figure = sensed_loops.loop_energy(own, np.zeros_like(share))
        elif setup.held == "slip":
            figure = sensed_loops.slip_amplitude(own, np.zeros_like(share))
        else:
            figure = force if setup.held == "tangential" else moved - chain.compliance_um_per_N * force
        return np.where(held, figure, stroke)

    # By what is left of the travel until sliding: of high orders, much of it is on the last of the force.
    low, high = 1e-15 ** (1.0 / contact.order), np.ones_like(tip)
    whole = reached(1.0 - low**contact.order) <= target
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        above = reached(1.0 - middle**contact.order) > target
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    return np.where(whole, 1.0, np.maximum(1.0 - high**contact.order, 1e-4))


def _missing_slip(setup: SurrogateInputs, chain: Chain, contact: SlidingContact, slip: Array) -> Array:
    """How much farther (n,) the contact has to slide for the drive to hold what it holds."""
    tip = contact.tip_N
    stroke = slip + sensed_loops.elastic_of(contact) * tip + 0.5 * chain.free_play_um
    if setup.held:
        missing = _missing_held(setup, chain, contact, slip)
        return np.where(np.isnan(chain.amplitude_um), missing, chain.amplitude_um - stroke)
    if setup.drive == "sensor":
        missing = chain.amplitude_um / chain.gain - stroke
        if (at := np.flatnonzero((chain.linear_um_per_N != 0.0) | (chain.quadratic_um_per_N2 != 0.0))).size:
            moved = chain.taken(at)
            half = half_reading(moved, *sensed_loops.branches_of(contact.taken(at), moved, slip[at]))
            missing[at] = (moved.amplitude_um - half) / moved.gain
        return missing
    return np.asarray(chain.amplitude_um - stroke)


def _missing_held(setup: SurrogateInputs, chain: Chain, contact: SlidingContact, slip: Array) -> Array:
    """By how much a loop misses the figure that the drive holds in place of its amplitude, (n,)."""
    target, tip = setup.held_share * setup.amplitude_um, contact.tip_N
    if setup.held == "tangential":
        # Beyond friction walls of the scar hold the force, which rises to them about as the contact slides.
        middle, slides = contact.force_N[..., contact.force_N.shape[-1] // 2].mean(axis=1), np.maximum(slip, 1e-3)
        rise = np.maximum(tip - middle, 1e-3 * tip)
        most = setup.largest_um - slip - sensed_loops.elastic_of(contact) * tip - 0.5 * chain.free_play_um
        return np.asarray(np.minimum(slides * (target - tip) / rise, most))
    if setup.held == "energy":
        per_um = 2e-3 * np.trapezoid(contact.force_N, sensed_loops.POSITIONS, axis=2).mean(axis=1)
        return np.asarray((target - sensed_loops.loop_energy(contact, slip)) / per_um)
    if setup.held == "motion":
        return np.asarray(target - slip - (sensed_loops.elastic_of(contact) - chain.compliance_um_per_N) * tip)
    return target - sensed_loops.slip_amplitude(contact, slip)


def half_reading(chain: Chain, x: Array, q: Array) -> Array:
    """Half of what a sensor that the force moves reads in all (n,) of loops with such branches (n, 2, m).

    A reading that leans against the force is outermost neither at the tip nor at the knee, but somewhere in stick.
    """
    gain, linear, quadratic = chain.gain, chain.linear_um_per_N, chain.quadratic_um_per_N2
    read = (gain * x.T + linear * q.T + quadratic * q.T**2).T
    return np.asarray(0.5 * np.ptp(read, axis=(1, 2)))
