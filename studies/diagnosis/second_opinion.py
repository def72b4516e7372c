"""A second opinion on records, to audit the diagnosis: sampled evidence, and a classifier taught by simulations.

    python -m studies.diagnosis.second_opinion OUTPUT RECORD... [--jobs 2] [--most-hours 1]

Both look at the same observables under the same covariance as the diagnosis. Nested sampling (dynesty) computes the
evidence of the likeliest effects, where the diagnosis takes Laplace's approximation about the best fit. The classifier
(networks of scikit-learn) has never seen an evidence: it learned from records that the fast model made for this one
record's test, of every effect and of none. Neither knows of pairs or of causes outside the library.

OUTPUT keeps an answer a record, in a folder named by the program's sources, so that an interrupted run goes on with the
same command. `--most-hours 0` computes nothing and sums up what is there.
"""

import json
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import click
import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from wirewear import RecordError, ResultError, WirewearError, read_record
from wirewear.base.engine import engine_of
from wirewear.base.identity import code_hash
from wirewear.base.reading import read_json
from wirewear.base.writing import prepared_folder, write_text
from wirewear.diagnosis import Diagnosed, diagnose
from wirewear.diagnosis.infer.weighing import Weighed, relevant
from wirewear.faces.study_script import StudyScript, understanding, wide_console

from .sampled_evidence import sampled_log_evidence
from .simulated_classifier import CLEAR, NONE, Signals, beliefs, taught

SAMPLED = 2  #: Effects whose evidence is sampled, the likeliest ones.
SURE = 0.8  #: Probability of what the diagnosis names, above which the classifier is to agree.
_FAR = 2.0  #: Deviations of what one expects beyond which few examples teach anything.


def opinion_on(diagnosed: Diagnosed, live: int, simulated: int, seed: int) -> dict[str, Any]:
    """What the diagnosis says of a record and what both others do."""
    found, verdict = diagnosed.search, diagnosed.diagnosis.verdict
    none, problem = found.none.log_evidence, found.problem
    signals = Signals.drawn(problem, found.singles, simulated, np.random.default_rng(seed))
    classifier, worth = taught(signals, seed)
    seen = problem.whitening @ (problem.mean - problem.predicted(problem.setup))
    learned = classifier.probabilities(seen[None], beliefs(found.singles))[0]
    by_name = dict(zip(classifier.names, learned.tolist(), strict=True))
    class_of = diagnosed.weighed.class_of
    masses = {name: sum(p for other, p in by_name.items() if other in class_of(name)) for name in by_name}
    chosen = max(by_name, key=lambda name: (masses[name], by_name[name]))
    fits = {one.names[0]: one for one in found.singles}
    other = found.none if chosen == NONE else fits[chosen]
    near = relevant(found.singles)[:SAMPLED]
    return {
        "verdict": verdict,
        "named": [] if verdict == "no_gap" else list(found.best.names),
        "probability": _probability(diagnosed.weighed, found.best.names if verdict != "no_gap" else ()),
        "classes": [list(class_of(name)) for name in found.best.names],
        "laplace": {one.names[0]: one.log_evidence - none for one in near},
        "sampled": {one.names[0]: sampled_log_evidence(problem, one, live, seed) - none for one in near},
        "learned": {name: p for name, p in by_name.items() if p > 0.005},
        "chosen": chosen,
        "chosen_probability": masses[chosen],
        "chosen_below_best": found.best.log_evidence - other.log_evidence,
        "best_above_none": found.best.log_evidence - none,
        "farthest_coordinate": float(np.abs(found.best.coordinates).max(initial=0.0)),
        "worth": vars(worth),
    }


def _probability(weighed: Weighed, names: tuple[str, ...]) -> float:
    """Of the class of an explanation, once it is given that the cause lies within the library."""
    wanted = sorted(weighed.class_of(name) for name in names)
    inside = {own: p for own, p in weighed.probabilities.items() if sorted(map(weighed.class_of, own)) == wanted}
    return sum(inside.values()) / max(sum(weighed.probabilities.values()), 1e-12)


def agrees(one: dict[str, Any]) -> bool:
    """Whether the classifier chooses what the diagnosis names: none, the class of an effect, or that of one of two."""
    if not one["named"]:
        return bool(one["chosen"] == NONE)
    return any(one["chosen"] in members for members in one["classes"])


def reason(one: dict[str, Any]) -> str:
    """Why the classifier chooses what the diagnosis does not name; empty where both agree."""
    if agrees(one):
        return ""
    below, far, sure = one["chosen_below_best"], one["farthest_coordinate"], one["chosen_probability"]
    if len(one["named"]) > 1:
        return "a pair, of which it knows single effects only"
    if below < CLEAR:
        return f"evidence has its choice {below:.1f} below the best: too little to tell"
    if sure < SURE:
        return f"it is unsure itself ({sure:.2f})"
    if far > _FAR:
        return f"the effect lies {far:.1f} deviations from what is expected, where there are few examples"
    return f"it errs: its choice leaves {below:.0f} of log evidence"


def answer(record: Path, kept: Path, live: int, simulated: int, seed: int) -> None:
    """Keep the opinions on a record, or why there are none."""
    from threadpoolctl import threadpool_limits

    began = time.process_time()
    try:
        with threadpool_limits(limits=1, user_api="blas"):
            diagnosed = diagnose(read_record(record))
            diagnosing = time.process_time() - began
            found = opinion_on(diagnosed, live, simulated, seed)
            found |= {"cpu_s": {"diagnosis": diagnosing, "opinions": time.process_time() - began - diagnosing}}
    except WirewearError as problem:
        found = {"failed": str(problem)}
    kept.parent.mkdir(parents=True, exist_ok=True)
    write_text(kept, json.dumps({"record": record.name, **found}, indent=1) + "\n")


@click.command(cls=StudyScript)
@click.argument("output", type=click.Path(path_type=Path))
@click.argument("records", nargs=-1, required=True, type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--live", type=click.IntRange(20), default=40, show_default=True, help="Live points of the sampler.")
@click.option("--simulated", type=click.IntRange(20), default=300, show_default=True, help="Records of every effect.")
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True)
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Records side by side.")
@click.option("--most-hours", type=click.FloatRange(min=0.0), default=24.0, show_default=True, help="Then stop.")
def main(
    output: Path, records: tuple[Path, ...], live: int, simulated: int, seed: int, jobs: int, most_hours: float
) -> None:
    """Set the diagnosis of RECORDS beside both other opinions, kept in OUTPUT."""
    until = time.monotonic() + 3600.0 * most_hours
    folder = prepared_folder(output) / f"opinions-{code_hash()[:12]}"
    kept = {record: folder / f"{record.resolve().parent.parent.name}_{record.name}.json" for record in records}
    tasks = [partial(answer, *one, live, simulated, seed) for one in kept.items() if not one[1].exists()]
    if most_hours > 0.0:
        for done in engine_of(jobs).done(tasks, until):
            done.value()
    console = wide_console(150)
    found = []
    for path in kept.values():
        if path.exists():
            one = read_json(path, ResultError, "file of this script's opinions")
            with understanding(path, "file of this script's opinions"):
                if "failed" in one:
                    console.print(f"{one['record']}: {one['failed']}", highlight=False)
                else:
                    found.append({**one, "reason": reason(one)})
    if not found:
        raise RecordError("there is no opinion yet: none of these is a record that can be diagnosed, or time is up.")
    with understanding(folder, "folder of this script's opinions"):
        console.print(_table(found))
        _sum_up(found, len(records), console)


def _table(found: Sequence[dict[str, Any]]) -> Table:
    heads = ("record", "verdict", "named", "log evidence, Laplace → sampled", "classifier", "why otherwise")
    table = Table(*heads, box=box.SIMPLE_HEAD)
    for one in found:
        named = f"{' + '.join(one['named']) or NONE} {one['probability']:.2f}"
        pairs = ", ".join(f"{name} {one['laplace'][name]:.1f} → {value:.1f}" for name, value in one["sampled"].items())
        chosen = f"{one['chosen']} {one['chosen_probability']:.2f}"
        table.add_row(one["record"], one["verdict"], named, pairs, chosen, one["reason"])
    return table


def _sum_up(found: Sequence[dict[str, Any]], asked: int, console: Console) -> None:
    gaps = [value - one["laplace"][name] for one in found for name, value in one["sampled"].items()]
    lines = [f"{len(found)} of {asked} records."]
    if gaps:
        largest = np.abs(gaps).max()
        lines.append(f"Sampled less Laplace's log evidence: {np.mean(gaps):+.2f} on average, {largest:.2f} at most.")
    clear, named, right, small, small_right = (
        sum(one["worth"][key] for one in found) for key in ("clear", "named", "right", "small", "small_right")
    )
    lines.append(
        f"Classifier on simulated records held out: above {CLEAR:.0f} scatters {right} of {clear} in the right class "
        f"({right / max(clear, 1):.1%}), {named / max(clear, 1):.1%} by name; below {small_right} of {small}."
    )
    sets = {
        f"named with more than {SURE}": [o for o in found if o["verdict"] == "explained" and o["probability"] > SURE],
        "named": [o for o in found if o["verdict"] in ("explained", "ambiguous")],
        "no gap": [o for o in found if o["verdict"] == "no_gap"],
        "unexplained, its best explanation": [o for o in found if o["verdict"] == "unexplained"],
    }
    for words, own in sets.items():
        agree = sum(map(agrees, own))
        lines.append(f"Of what is {words}, the classifier agrees on {agree} of {len(own)}.")
    spent = [one["cpu_s"] for one in found]
    times = {key: np.median([one[key] for one in spent]) for key in ("diagnosis", "opinions")}
    lines.append(f"CPU of a record (median): diagnosis {times['diagnosis']:.0f} s, opinions {times['opinions']:.0f} s.")
    for line in lines:
        console.print(line, highlight=False)


if __name__ == "__main__":
    main()
