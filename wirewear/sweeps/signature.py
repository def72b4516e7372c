"""Signature of an effect: the difference between a run of one study without the effect and a run with it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from importlib.resources import files
from pathlib import Path

import numpy as np

from geometry.arrays import Array
from wirewear.base.errors import RunError
from wirewear.effects import AnyEffect, Seam
from wirewear.loops import LoopFigures, analyse_loop
from wirewear.results import Loop, RunResult, read_loops
from wirewear.simulation import ObserverOf, run_study
from wirewear.test import Study, parse_study

_STUDY = "signature_study.toml"


def signature_study() -> Study:
    """The steel-wire test on which signatures are drawn by default."""
    text = files("wirewear.sweeps").joinpath(_STUDY).read_text(encoding="utf-8")
    return parse_study(text, _STUDY)


@dataclass(frozen=True)
class Signature:
    """Run of the nominal model, without effects, and run with the effect; their loops are the sensors' readings."""

    effect: AnyEffect
    nominal: RunResult
    changed: RunResult

    @cached_property
    def loops(self) -> tuple[tuple[Loop, Loop], ...]:
        """Pairs (nominal, with the effect) of loops of the same cycle, as sensors read them."""
        return tuple(zip(read_loops(self.nominal), read_loops(self.changed), strict=True))

    def on_one_phase(self, place: int) -> tuple[Array, Array, Array]:
        """(phases (n,), nominal (2, n), changed (2, n)): phases of the drive from 0 to 1, and displacement in µm and
        force in N there.

        place: index of the pair in `loops`. Both loops are interpolated linearly at the phases of all their samples.
        """
        pair = self.loops[place]
        turns = [float(self.nominal.study["conditions"]["frequency_Hz"]) * loop.time_s % 1.0 for loop in pair]
        phase = np.unique(np.concatenate([*turns, [0.0, 1.0]]))
        channels = [
            [
                np.interp(phase, turn, getattr(loop, name), period=1.0)
                for name in ("displacement_um", "tangential_force_N")
            ]
            for turn, loop in zip(turns, pair, strict=True)
        ]
        first, second = np.array(channels)
        return phase, first, second

    @cached_property
    def cycles(self) -> tuple[int, ...]:
        return tuple(nominal.cycle for nominal, _ in self.loops)

    @cached_property
    def figures(self) -> tuple[tuple[LoopFigures, LoopFigures], ...]:
        """Figures of each pair of loops (nominal, with the effect), as `analyse_loop` finds them."""
        return tuple((_figures(nominal), _figures(changed)) for nominal, changed in self.loops)

    def changes(self) -> Mapping[str, list[float]]:
        """Change of slip amplitude, dissipated energy and largest friction over the nominal value, by name, for each
        pair of loops; NaN where not measured.
        """
        names = ("slip_amplitude_um", "dissipated_energy_mJ", "friction_max")
        return {
            name: [_value(changed, name) / _value(nominal, name) - 1.0 for nominal, changed in self.figures]
            for name in names
        }


def signature_of(
    effect: AnyEffect,
    output: Path,
    *,
    study: Study | None = None,
    fidelity: str = "quick",
    observer_of: ObserverOf | None = None,
) -> Signature:
    """Run a study (None: `signature_study`) without and with an effect, in OUTPUT/nominal and OUTPUT/<effect>; finished
    runs are reused.

    An interrupted run is continued; one of another study, fidelity or version is replaced. An effect of the sensor
    needs no run of its own, as it does not change the test. Raises SolverError or StudyError as `run_study` does.
    """
    base = study or signature_study()
    nominal = _run(base.with_effects(), "nominal", output, fidelity, observer_of)
    study = base.with_effects(effect)
    if effect.seam is Seam.SENSOR:
        return Signature(effect, nominal, replace(nominal, study=study.resolved()))
    return Signature(effect, nominal, _run(study, effect.name, output, fidelity, observer_of))


def _run(study: Study, name: str, output: Path, fidelity: str, observer_of: ObserverOf | None) -> RunResult:
    observe = (lambda _: observer_of(name)) if observer_of else None
    run = partial(run_study, study, fidelity=fidelity, output=output / name, observer_of=observe)
    try:
        (result,) = run(resume=True)
    except RunError:
        (result,) = run()
    return result


def _figures(loop: Loop) -> LoopFigures:
    return analyse_loop(loop.displacement_um, loop.tangential_force_N, loop.normal_force_N, time_s=loop.time_s)


def _value(figures: LoopFigures, name: str) -> float:
    measured = getattr(figures, name)
    return float("nan") if measured is None else float(measured.value)
