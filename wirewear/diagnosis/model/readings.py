"""What the sensors of a rig read of both branches of a loop."""

from __future__ import annotations

import numpy as np

from wirewear.diagnosis.model.branches import STICK
from wirewear.diagnosis.model.setup import Array, Setup
from wirewear.effects import Chain


def read_by_sensors(setup: Setup, chain: Chain, x: Array, q: Array, load: Array) -> tuple[Array, Array, Array]:
    """Both branches (n, 2, m) as the sensors read them, and the normal force; `load` (n, k) of those that slide."""
    # A branch sticks under the load of the end where it begins; the other way the load is the same, mirrored.
    there = np.concatenate([np.repeat(load[:, :1], STICK.size, axis=1), load[:, 1:]], axis=1)
    x = np.stack([x, -x], axis=1)
    q = np.stack([q, -q], axis=1)
    p = np.stack([there, there], axis=1)
    tilt, gain, linear, quadratic, crosstalk, lag_s, force_lag_s, zero = (
        column[:, None, None]
        for column in (
            chain.misalignment_rad,
            chain.gain,
            chain.linear_um_per_N,
            chain.quadratic_um_per_N2,
            chain.crosstalk,
            chain.lag_s,
            chain.force_lag_s,
            chain.force_zero_N,
        )
    )
    if tilt.any():
        # A wire that climbs presses the loading spring, and friction follows the load.
        holder = chain.compliance_um_per_N[:, None, None]
        relative = x - holder * q
        share = 1.0 + setup.normal_spring_N_per_um * np.tan(tilt) * relative / p
        p, q = share * p, share * q
        # Q = P tan(φ ± β): climbing on one stroke, descending on the other.
        q = q + np.tan(tilt) * (p + q**2 / p)
        x = relative + holder * q
    direction = np.array([1.0, -1.0])[:, None]
    read = gain * x + linear * q + quadratic * q**2
    if lag_s.any():
        # A drive that is a sine passes x with the speed ω sqrt(A² − x²); a filter's lag turns its phase.
        turn = np.arctan(2.0 * np.pi * setup.frequency_Hz * lag_s)
        half = 0.5 * (read.max(axis=-1, keepdims=True) - read.min(axis=-1, keepdims=True))
        read = np.cos(turn) * read - np.sin(turn) * direction * np.sqrt(np.maximum(half**2 - read**2, 0.0))
    # Measured loops are centred between their tips, whatever moves the reading as a whole.
    centre = 0.5 * (read.max(axis=(1, 2), keepdims=True) + read.min(axis=(1, 2), keepdims=True))
    q, p = q + crosstalk * p + zero + setup.force_offset_N, p + crosstalk * q
    if force_lag_s.any():
        q = late_forces(q, x, 2.0 * np.pi * setup.frequency_Hz * chain.force_lag_s)
    return read - centre + setup.displacement_offset_um, q, p


def late_forces(q: Array, x: Array, lag: Array) -> Array:
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
