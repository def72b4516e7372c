"""Diagnoses of finished simulations, and of records, beside what is known to be in them.

    python -m studies.diagnosis.check RESULT_OR_RECORD... [--output DIR] [--repeats N] [--samples N] [--seed N]

A result (result.h5, or the folder that holds it) is read by noisy sensors into a record of several repeats, which
states the nominal model only; its truth are the effects of its study. Records are diagnosed as they are. Diagnoses are
left in DIR/<name>, one line each is printed, and the figures of merit below: false alarms among results without an
effect, and how many effects were found and put into the right class.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import click
from rich import box
from rich.table import Table

from studies.study_script import StudyScript
from wirewear import ExperimentRecord, RecordError, WirewearError, read_record
from wirewear.app.cli.consoles import wide_console
from wirewear.diagnosis import Diagnosis, diagnose
from wirewear.loops.sensor import Sensor, SensorNoise
from wirewear.records.exporting import record_of_result
from wirewear.results import RESULT_FILE_NAME, read_result
from wirewear.simulation import ProgressBar
from wirewear.views.diagnosis_page import write_diagnosis

#: Sensors that read a simulation: noise of a sample in µm and N, of a scar's map in µm.
NOISE, DEPTH_NOISE_um = SensorNoise(0.15, 0.008, 0.01), 0.1


@dataclass(frozen=True)
class Case:
    """A record with the effects that are in it; None where nobody says."""

    name: str
    record: ExperimentRecord
    truth: tuple[str, ...] | None


@dataclass(frozen=True)
class Outcome:
    """A case and its diagnosis."""

    case: Case
    diagnosis: Diagnosis

    @property
    def named(self) -> tuple[str, ...]:
        """The effects that the diagnosis holds for possible: the leading explanation, each with its class."""
        causes = [cause for cause in self.diagnosis.causes if cause.effect not in ("none", "outside_library")]
        if self.diagnosis.verdict not in ("explained", "ambiguous") or not causes:
            return ()
        leading = [cause.effect for cause in causes if cause.joint][:2] if causes[0].joint else [causes[0].effect]
        alike = {name for name in leading for group in self.diagnosis.equivalent if name in group for name in group}
        return tuple(sorted({*leading, *alike}))

    @property
    def judgement(self) -> str:
        """How the diagnosis compares with the truth."""
        truth, verdict = self.case.truth, self.diagnosis.verdict
        if truth is None:
            return ""
        if not truth:
            return "right" if verdict == "no_gap" else "false alarm"
        if verdict == "no_gap":
            return "declared unseen" if set(truth) <= set(self.diagnosis.undetectable) else "missed"
        return "right class" if set(truth) <= set(self.named) else "wrong class"


def case_of(path: Path, repeats: int, seed: int, samples: int | None = None) -> Case:
    """The case that a result or a record makes. Raises WirewearError if it is neither, or cannot be read."""
    file = path / RESULT_FILE_NAME if path.is_dir() else path
    if not file.is_file():
        return Case(path.name, read_record(path), None)
    result = read_result(file)
    record = record_of_result(
        result, sensor=Sensor(noise=NOISE), depth_noise_um=DEPTH_NOISE_um, repeats=repeats, seed=seed, samples=samples
    )
    name = "_".join(part for part in file.parent.parts[-2:] if part != "/")
    return Case(name, record, tuple(str(effect["name"]) for effect in result.study.get("effects", ())))


def outcome_table(outcomes: Sequence[Outcome]) -> Table:
    """Table with one row for each case."""
    table = Table("case", "truth", "verdict", "named", "before → after (floor)", "judgement", box=box.SIMPLE_HEAD)
    for one in outcomes:
        shrink, truth = one.diagnosis.shrink, one.case.truth
        table.add_row(
            one.case.name,
            "?" if truth is None else ", ".join(truth) or "no effect",
            one.diagnosis.verdict,
            ", ".join(one.named),
            f"{shrink.before:.2f} → {shrink.after:.2f} ({shrink.floor:.2f})",
            one.judgement,
        )
    return table


def summary(outcomes: Sequence[Outcome]) -> list[str]:
    """The figures of merit, a sentence each."""
    known = [one for one in outcomes if one.case.truth is not None]
    free = [one for one in known if not one.case.truth]
    seeable = [one for one in known if one.case.truth and one.judgement != "declared unseen"]
    right = [one for one in seeable if one.judgement == "right class"]
    shrunk = [one for one in right if one.diagnosis.shrink.after <= 1.2 * one.diagnosis.shrink.floor]
    unseen, alarms = (sum(one.judgement == words for one in known) for words in ("declared unseen", "false alarm"))
    return [
        f"{alarms} false alarms in {len(free)} records without an effect.",
        f"{len(right)} of {len(seeable)} effects found and in the right class, {unseen} declared unseen beside them.",
        f"{len(shrunk)} of these {len(right)} leave a gap of at most 1.2 floors on held-out loops.",
    ]


@click.command(cls=StudyScript)
@click.argument("paths", nargs=-1, required=True, type=click.Path(exists=True, path_type=Path))
@click.option("--output", type=click.Path(path_type=Path), default=Path("runs/diagnosis"), show_default=True)
@click.option("--repeats", type=click.IntRange(1), default=3, show_default=True)
@click.option(
    "--samples", type=click.IntRange(16), help="Of a loop, straight between a run's increments.  [default: at these]"
)
@click.option(
    "--seed", type=click.IntRange(0), default=1, show_default=True, help="Of the sensors' noise; one more each."
)
def main(paths: tuple[Path, ...], output: Path, repeats: int, samples: int | None, seed: int) -> None:
    """Diagnose results and records, and judge the answers."""
    console = wide_console(150)
    outcomes = []
    for place, path in enumerate(paths):
        try:
            case = case_of(path, repeats, seed + place, samples)
            diagnosed = diagnose(case.record, observer_of=ProgressBar)
            write_diagnosis(diagnosed, output / case.name)
        except (WirewearError, OSError) as error:
            console.print(f"{path}: {error}", soft_wrap=True, highlight=False)
            continue
        outcomes.append(Outcome(case, diagnosed.diagnosis))
    if not outcomes:
        raise RecordError("none of these is a result or a record that can be diagnosed.")
    console.print(outcome_table(outcomes))
    for sentence in summary(outcomes):
        console.print(sentence, highlight=False)


if __name__ == "__main__":
    main()
