"""Whether the measurement that a diagnosis proposes settles it: sparse records, the proposal simulated, both diagnosed.

    python -m studies.blind.next_measurements OUTPUT [--effect NAME] [--seed N] [--ease easy] [--most 3]

The independent model (T2) makes a record of two loops with one effect, read by a sensor. Where the answer sees a gap
and holds several effects for possible, the proposed measurement is made on the same rig with other specimens, and so
on. What is then possible is counted: effects of the classes that hold the cause in nine of ten (`set90`), one of those
that no record of wires tells apart. Each answer stays in OUTPUT; the table is of all that are there.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import click
import numpy as np

from studies.blind.answering import write_json
from studies.blind.generators.cases import Case, TrueEffect, exact_class
from studies.blind.generators.generator import LIBRARY_EFFECTS
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.generators.independent.world import World
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.nuisances import Nuisances, drawn_nuisances
from studies.blind.generators.sizes import drawn_parameters
from wirewear import WirewearError
from wirewear.diagnosis import Diagnosis, diagnose
from wirewear.diagnosis.infer.search import next_measurement
from wirewear.effects import Measurement, measurements
from wirewear.faces.study_script import StudyScript
from wirewear.records import AnyRecord

Test = tuple[Nominal, Nuisances]

SPARSE: Mapping[str, Any] = {"repeats": 1, "drive": "sensor", "has_normal_force": False, "has_evolution": False,
                             "has_scars": False, "loop_cycles": ((100, 10_000),)}  # fmt: skip
HALF_DECADES = (1, 3, 10, 30, 100, 300, 1000, 3000, 10_000)

#: Tests that make a proposed measurement, from one that goes on to the end. What is not here no record holds: a second
#: sensor, a stroke without contact, maps of cleaned scars.
MADE: Mapping[Measurement, Callable[[Nominal, Nuisances], list[Test]]] = {
    measurements.ENCODER: lambda n, own: [(n, replace(own, drive="stroke"))],
    measurements.NORMAL_FORCE: lambda n, own: [(n, replace(own, has_normal_force=True))],
    measurements.HALF_LOAD: lambda n, own: [(replace(n, load_N=0.5 * n.load_N), own)],
    measurements.OTHER_STROKE: lambda n, own: [(replace(n, amplitude_um=0.5 * n.amplitude_um), own)],
    measurements.LOWER_FREQUENCY: lambda n, own: [(replace(n, frequency_Hz=0.1 * n.frequency_Hz), own)],
    measurements.EARLY_LOOPS: lambda n, own: [(n, replace(own, loop_cycles=(HALF_DECADES,)))],
    measurements.SCAR_MAPS: lambda n, own: [(n, replace(own, has_scars=True))],
    measurements.INTERRUPTED_SCARS: lambda n, own: [
        (replace(n, cycles=last), replace(own, has_scars=True, loop_cycles=((last,),))) for last in (10, 1000, 30_000)
    ],
}


@dataclass(frozen=True)
class Rig(IndependentModel):
    """A rig that has one effect in every test; what that changes is not computed."""

    own: tuple[TrueEffect, ...] = ()

    def true_world(self, case: Case) -> World:
        """The world with it."""
        return super().true_world(replace(case, effects=self.own))


def possible(answer: Diagnosis) -> set[frozenset[str]]:
    """Effects that an answer holds for possible, those that no record of wires tells apart as one."""
    named = {name for members in answer.plausible for name in members} - {"none", "outside_library"}
    return {exact_class(name) for name in named}


def settled(effect: str, ease: str, seed: int, most: int) -> dict[str, Any]:
    """The row of one effect: of each answer the verdict, what is possible, and whether the effect is among it."""
    random, nominal = np.random.default_rng([seed, LIBRARY_EFFECTS.index(effect)]), Nominal()
    true = TrueEffect(effect, drawn_parameters(effect, ease, nominal, random))
    looks = replace(drawn_nuisances(nominal, random), **SPARSE)

    def made(test: Test) -> AnyRecord:
        case = Case("record", "single", ease, (), (), *test, seed=int(random.integers(2**63)))
        return Rig(own=(true,)).make(case).record

    first, answers = made((nominal, looks)), []
    further: list[AnyRecord] = []
    proposed: list[Measurement] = []
    while True:
        answer = diagnose(first, further=further).diagnosis
        names, known = possible(answer), {cause.effect: cause.probability for cause in answer.causes}
        answers.append((answer.verdict, sorted(map(min, names)), exact_class(effect) in names))
        # As the diagnosis proposes, but nothing twice.
        unsettled = len(names) > 1 and answer.verdict != "no_gap"
        asked = next_measurement(known, answer.equivalent, frozenset(proposed)) if unsettled else None
        if asked and len(proposed) < most:
            proposed.append(asked[0])
        if not asked or len(answers) > most or asked[0] not in MADE:
            return {"truth": effect, "answers": answers, "proposed": [one.what for one in proposed]}
        to_the_end = replace(looks, loop_cycles=((100, 10_000, nominal.cycles),))
        further += [made(test) for test in MADE[asked[0]](nominal, to_the_end)]


@click.command(cls=StudyScript)
@click.argument("output", type=click.Path(path_type=Path))
@click.option("--effect", "effects", type=click.Choice(LIBRARY_EFFECTS), multiple=True, help="[default: all]")
@click.option("--ease", type=click.Choice(("easy", "hard")), default="easy", show_default=True)
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True)
@click.option("--most", type=click.IntRange(1), default=3, show_default=True, help="Measurements one after another.")
def main(output: Path, effects: tuple[str, ...], ease: str, seed: int, most: int) -> None:
    """Propose, simulate and diagnose further measurements of each effect, and count what stays possible."""
    for effect in effects or LIBRARY_EFFECTS:
        if not (file := output / f"{effect}_{ease}_{seed}.json").exists():
            try:
                write_json(file, settled(effect, ease, seed, most))
            except WirewearError as problem:
                click.echo(f"{effect}: {problem}")
    rows = [json.loads(file.read_text(encoding="utf-8")) for file in sorted(output.glob("*.json"))]
    for row in rows:
        told = (f"{verdict} {len(names)}{'' if held else ' without it'}" for verdict, names, held in row["answers"])
        click.echo(f"{row['truth']}: {', then '.join(told)}; {', then '.join(row['proposed']) or 'nothing'} proposed.")
    for done in range(1, most + 1):
        counts = [len(own[min(done, len(own) - 1)][1]) for row in rows if len(own := row["answers"]) > 1]
        few = sum(count <= 1 for count in counts)
        click.echo(f"After {done}: {np.mean(counts):.2f} effects possible of {len(counts)} records, one in {few}.")


if __name__ == "__main__":
    main()
