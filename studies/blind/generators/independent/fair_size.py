"""How large a gap is, fairly: the whitened distance that the best imitation leaves, by what a diagnosis may name.

All figures of readings and scars of a test count together; those taken from others (energy, largest force) are left
out. Their covariance is what no diagnosis can know of a test without a gap: noise, the scatter of its specimens, the
zeros of both channels, the drift of the stroke, and by which law friction is mobilised. An imitation is one effect of
the library: its changes at a few sizes and at the case's own, in any mixture. So the distance is one of linear algebra.
What two solvers of one law differ by is not in it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from studies.blind.generators.cases import Case, exact_class
from studies.blind.generators.independent.effects import changed
from studies.blind.generators.independent.friction import LAWS
from studies.blind.generators.independent.model import (
    COMPARED,
    PHASES,
    IndependentModel,
    expected_figures,
    figure_scatter,
    figures_of,
    is_recorded,
)
from studies.blind.generators.independent.worlds import nominal_world, with_specimens
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.nuisances import DISPLACEMENT_ZERO, FORCE_ZERO, Scatter, SpecimenDraw
from studies.blind.generators.sizes import drawn_parameters
from wirewear.base.errors import RunError

Array = NDArray[np.float64]

#: Figures that follow from the loop's shape.
DERIVED = ("dissipated_energy_mJ", "max_tangential_force_N", "mean_force_N")

UNKNOWN_ZERO = 0.01  #: A charge amplifier's zero is known within this share of the largest force.
LEAST_NOISE = 0.05  #: Noise of a figure is at least this share of one test's standard deviation.
TRIED = ("hard", "easy", "easy")  #: Sizes at which an effect is tried as an imitation.


def fair_size(case: Case, model: IndependentModel) -> float:
    """The distance, in standard deviations, that is left of a case's gap; 0 without one.

    A single effect is imitated by none but the scatter; two effects, and what is in no library, by each effect alone
    that a diagnosis of the case may name.
    Raises RunError if the contact does not slip.
    """
    if not case.effects:
        return 0.0
    cycles = _cycles(case.nominal)
    expected, sensitivities = expected_figures(case.nominal, model, cycles, case.nuisances.drive == "sensor")
    try:
        found = figures_of(model.true_world(case), cycles, model.points)
    except ArithmeticError as error:
        raise RunError(f"{case.name} cannot be made: {error}") from error
    names = [name for name in found if is_recorded(name, case) and name.split(" ", 1)[0] not in DERIVED]
    still = replace(case, nuisances=replace(case.nuisances, scatter=Scatter(0.0, 0.0, 0.0, 0.0)))
    noise = _row(figure_scatter(expected, sensitivities, still), names) / _averaged(expected, names, case)
    # A figure that is zero without an effect has no noise of its own.
    noise = np.maximum(noise, LEAST_NOISE * _row(figure_scatter(expected, sensitivities, case), names))
    rows = [_row(own, names) * getattr(case.nuisances.scatter, source) for source, own in sensitivities.items()]
    rows += [_row(one, names) - _row(expected, names) for one in _unknown(case, model, cycles, expected)]
    scatter = np.stack(rows) / noise
    change = (_row(found, names) - _row(expected, names)) / noise
    imitations: list[Array | None] = [None]
    if case.kind != "single":
        # What moves is the same for all cases of a test, what a record holds of it is not.
        columns = _imitations(case.nominal, model, case.nuisances.drive)
        barred = {name for one in case.left_out for name in exact_class(one)}
        imitations += [
            np.stack(
                [(_row(one, names) - _row(expected, names)) / noise for one in (*own, *_alone(case, model, effect))]
            )
            for effect, own in columns.items()
            if effect not in barred and own
        ]
    return min(_left(change, scatter, one) for one in imitations)


def _unknown(
    case: Case, model: IndependentModel, cycles: tuple[int, ...], expected: Mapping[str, Array]
) -> list[Mapping[str, Array]]:
    """Figures of tests without a gap, each a deviation off in what neither specimens nor noise make unsure."""
    nuisances, held = case.nuisances, case.nuisances.drive == "sensor"
    stated = nominal_world(case.nominal, model.law, held_on_sensor=held)
    largest = max(float(values.max()) for name, values in expected.items() if name.startswith("loop_shape"))
    off = (
        SpecimenDraw(displacement_zero_um=DISPLACEMENT_ZERO * nuisances.displacement_noise_um),
        SpecimenDraw(force_zero_N=float(np.hypot(UNKNOWN_ZERO * largest, FORCE_ZERO * nuisances.force_noise_N))),
    )
    worlds = [with_specimens(stated, draw) for draw in off]
    if nuisances.amplitude_drift:
        worlds.append(replace(stated, drive=replace(stated.drive, amplitude_drift=nuisances.amplitude_drift)))
    others = _by_other_laws(case.nominal, model, cycles, held)
    return [*(figures_of(world, cycles, model.points) for world in worlds), *others]


@lru_cache(maxsize=64)
def _by_other_laws(
    nominal: Nominal, model: IndependentModel, cycles: tuple[int, ...], held: bool
) -> tuple[Mapping[str, Array], ...]:
    """Figures of the test without a gap, by each law of friction but the model's own."""
    worlds = (nominal_world(nominal, law, held_on_sensor=held) for law in LAWS if law != model.law)
    return tuple(figures_of(world, cycles, model.points) for world in worlds)


def _cycles(nominal: Nominal) -> tuple[int, ...]:
    return tuple(sorted({max(round(part * nominal.cycles), 1) for part in COMPARED}))


def _row(figures: Mapping[str, Array], names: Sequence[str]) -> Array:
    return np.concatenate([np.atleast_1d(figures[name]) for name in names])


def _averaged(figures: Mapping[str, Array], names: Sequence[str], case: Case) -> Array:
    """By how much less noise a phase of the loop's shape has than one sample: several samples fall on it."""
    samples = max(case.nuisances.samples / PHASES, 1.0)
    return np.concatenate(
        [np.full(figures[name].size, np.sqrt(samples) if name.startswith("loop_shape") else 1.0) for name in names]
    )


def _left(change: Array, scatter: Array, imitation: Array | None) -> float:
    """Distance of changes (n,) beside unit deviates along scatter (k, n) and any mixture of an imitation (j, n)."""
    inverse = np.eye(scatter.shape[0]) + scatter @ scatter.T

    def whitened(rows: Array, others: Array) -> Array:
        return np.asarray(rows @ others.T - rows @ scatter.T @ np.linalg.solve(inverse, scatter @ others.T))

    squares = float(whitened(change[None], change[None])[0, 0])
    if imitation is not None:
        normal = whitened(imitation, imitation)
        along = whitened(imitation, change[None])[:, 0]
        squares -= float(along @ np.linalg.lstsq(normal, along, rcond=1e-9)[0])
    return float(np.sqrt(max(squares, 0.0)))


def _alone(case: Case, model: IndependentModel, effect: str) -> list[Mapping[str, Array]]:
    """Figures with an effect as large as a case has it, but no other; none if the case does not have it."""
    stated = nominal_world(case.nominal, model.law, held_on_sensor=case.nuisances.drive == "sensor")
    return [
        figures_of(changed(stated, effect, one.parameters), _cycles(case.nominal), model.points)
        for one in case.effects
        if one.effect == effect
    ]


@lru_cache(maxsize=64)
def _imitations(nominal: Nominal, model: IndependentModel, drive: str) -> dict[str, list[Mapping[str, Array]]]:
    """Figures with each effect of the library at a few sizes, in a test held so."""
    stated = nominal_world(nominal, model.law, held_on_sensor=drive == "sensor")
    random = np.random.default_rng(1)
    found: dict[str, list[Mapping[str, Array]]] = {}
    for effect in model.library:
        rows = found.setdefault(effect, [])
        for ease in TRIED:
            parameters = drawn_parameters(effect, ease, nominal, random)
            try:
                rows.append(figures_of(changed(stated, effect, parameters), _cycles(nominal), model.points))
            except ArithmeticError:
                # A size under which the contact does not slip imitates nothing.
                continue
    return found
