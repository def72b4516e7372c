"""What each gate, tempering and margin of the diagnosis earns, on development records.

    python -m studies.blind make BATCH --cases 60 --seed N --tier T2 --law dahl --outside development --tests 5
    python -m studies.blind.ablations ANSWERS BATCH...
    python -m studies.blind.ablations ANSWERS --frozen T2 [--article]

Every record is searched once; the search is then judged with one part taken out at a time. The keys of the batches are
opened, so they are development records from then on, as frozen records are. Answers are kept in ANSWERS: an interrupted
run goes on with the same command, by the same code only.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import PropertyMock, patch

import click
from rich import box
from rich.table import Table

from studies.blind import TIERS, Judgement, Truth, default_key_path, verified
from studies.blind.scoring.answers import answer_of
from studies.blind.scoring.figures import LARGE_GAP
from studies.blind.scoring.judging import judged
from studies.blind.scoring.statistics import area_under_curve
from studies.json_files import read_json
from studies.study_script import StudyScript, understanding
from wirewear import ResultError, WirewearError, read_record
from wirewear.app.cli.consoles import wide_console
from wirewear.base.writing import prepared_folder
from wirewear.diagnosis import Diagnosed, diagnose
from wirewear.diagnosis import record_diagnosis as judging
from wirewear.diagnosis.infer import weighing
from wirewear.diagnosis.infer.inference import Fit
from wirewear.diagnosis.infer.search import Search
from wirewear.diagnosis.infer.shrink import Shrink
from wirewear.diagnosis.infer.where import Place, Relevance, relevance_of
from wirewear.diagnosis.surrogate.candidates import Candidate

from .answering import BASELINES, baseline_answers, write_json
from .frozen import frozen_records, unpack

Change = Callable[[Search], Search]  #: What is taken out of a search before it is judged.


@dataclass(frozen=True)
class Part:
    """A part of the judgement: what is patched while it is taken out, and what becomes of the search."""

    words: str
    without: Callable[[], Any] = nullcontext
    changed: Change = lambda found: found


def _given(place: int, value: object) -> Callable[[], Any]:
    """The weighing with one of its arguments exchanged."""

    @contextmanager
    def exchanged() -> Iterator[None]:
        whole: Callable[..., Any] = weighing.weigh

        def weigh(*given: object) -> object:
            return whole(*given[:place], value, *given[place + 1 :])

        with patch.object(judging, "weigh", weigh):
            yield

    return exchanged


def _tolerant(factor: float) -> Callable[[], Any]:
    """The judgement with all tolerances so many times as large."""

    def tolerant(places: Sequence[Place], tolerance: Mapping[str, float], *, detected: bool) -> Relevance:
        wider = {name: factor * size for name, size in tolerance.items()}
        return relevance_of(places, wider, detected=detected)

    return partial(patch.object, judging, "relevance_of", tolerant)


def _unallowed(found: Search) -> Search:
    """All that families gain, without what friction laws are allowed to add to them."""
    more = tuple(replace(one, gain=one.gain + one.family.allowed) for one in found.distortions)
    return replace(found, distortions=more)


PARTS = (
    Part("as it is"),
    Part("no difference is tolerated", _tolerant(0.0)),
    Part("tolerances are halved", _tolerant(0.5)),
    Part("tolerances are doubled", _tolerant(2.0)),
    Part("log evidences are not tempered", partial(patch.object, weighing, "TEMPERATURE", 1.0)),
    Part("a misfit tempers nothing further", _given(4, 1.0)),
    Part("less misfit counts for no more", partial(patch.object, judging, "LEAST_DISPERSION", 1.0)),
    Part("no surprise by what is left over", _given(5, 0.0)),
    Part("no families of distortions", _given(6, {})),
    Part("a slipping holder is allowed nothing", changed=_unallowed),
    Part(
        "held-out cycles need not bear it out",
        partial(patch.object, Shrink, "supports", new_callable=PropertyMock, return_value=True),
    ),
)


def answers_of(record: Path, left_out: Sequence[str]) -> dict[str, Any]:
    """The answers to a record by each part's words, and those of the baselines."""
    whole = diagnose(read_record(record), left_out=left_out)
    with _remembered(Search, "apart"), _remembered(judging, "shrink_of"), _remembered(judging, "undetectable"):
        found = {part.words: _judged_without(part, whole) for part in PARTS}
    return found | baseline_answers(whole)


@contextmanager
def _remembered(owner: object, name: str) -> Iterator[None]:
    """A step of the judgement that costs much and depends on which fits it is given alone, done once for each."""
    step: Callable[..., object] = getattr(owner, name)
    known: dict[tuple[object, ...], object] = {}

    def once(*given: object) -> object:
        key = tuple(_names(one) for one in given)
        if key not in known:
            known[key] = step(*given)
        return known[key]

    with patch.object(owner, name, once):
        yield


def _names(given: object) -> object:
    """What distinguishes the arguments of one record's judgements."""
    if isinstance(given, Fit):
        return given.names
    if isinstance(given, Candidate):
        return given.name
    if isinstance(given, list | tuple):
        return tuple(_names(one) for one in given)
    return type(given).__name__


def _judged_without(part: Part, whole: Diagnosed) -> dict[str, Any]:
    with part.without():
        again = judging.judged(whole.record, whole.study, whole.states, whole.observed, part.changed(whole.search))
    judged = again.diagnosis.to_json()
    return {key: judged[key] for key in ("format", "verdict", "causes", "equivalent", "undetectable", "gap")}


def kept_answers(folder: Path, batch: Path) -> list[tuple[Truth, Mapping[str, Any]]]:
    """Truths of a batch with the answers to its records, those that are not there yet made now."""
    known = verified(batch, default_key_path(batch))
    found = []
    for truth in known.truths:
        path = folder / batch.name / f"{truth.case}.json"
        if not path.exists():
            try:
                write_json(path, answers_of(batch / truth.case, known.manifest["cases"][truth.case]["left_out"]))
            except WirewearError as problem:
                click.echo(f"{truth.case}: {problem}")
                continue
        found.append((truth, _kept(path)))
    return found


def frozen_answers(folder: Path, tiers: Sequence[str], article: bool) -> list[tuple[Truth, Mapping[str, Any]]]:
    """Truths of frozen records, and their answers."""
    records = frozen_records(tiers, article_only=article) if tiers else ()
    unpack(records, folder / "records")
    found = []
    for one in records:
        path = folder / "frozen" / f"{one.name}.json"
        if not path.exists():
            write_json(path, answers_of(folder / "records" / one.name, one.left_out))
        found.append((one.truth, _kept(path)))
    return found


def _kept(path: Path) -> Mapping[str, Any]:
    answers: Mapping[str, Any] = read_json(path, ResultError, "file of answers")
    with understanding(path, "file of this script's answers"):
        for words in (*(part.words for part in PARTS), *BASELINES):
            answer_of(answers[words])
    return answers


def all_answers(
    folder: Path, batches: Sequence[Path], tiers: Sequence[str], article: bool
) -> list[tuple[Truth, Mapping[str, Any]]]:
    """Truths of all batches and of the frozen records of these tiers, and their answers.
    Raises WirewearError if there is none, or a batch or an answer cannot be read.
    """
    prepared_folder(folder)
    found = [one for batch in batches for one in kept_answers(folder, batch)]
    found += frozen_answers(folder, tiers, article)
    if not found:
        raise ResultError("there is no record to judge: name a batch whose records can be diagnosed, or --frozen TIER.")
    return found


def figures(judgements: Sequence[Judgement]) -> dict[str, str]:
    """The figures of merit, as text."""

    def of(own: Sequence[bool]) -> str:
        return f"{sum(own)} of {len(own)}"

    singles = [one for one in judgements if one.truth.kind == "single"]
    large = [one for one in singles if one.truth.gap_in_scatter > LARGE_GAP]
    opened = [one for one in judgements if one.truth.is_open and one.truth.gap_in_scatter > LARGE_GAP]
    known = [one for one in judgements if one.truth.kind in ("single", "pair")]
    area = area_under_curve([one.outside_score for one in opened], [one.outside_score for one in known])
    pairs = [one for one in judgements if one.truth.kind == "pair"]
    return {
        "alarms": of([one.gap_seen for one in judgements if one.truth.kind == "none"]),
        "right > 5": of([one.first_right for one in large]),
        "right ≤ 5": of([one.first_right for one in singles if one not in large]),
        "right, named": of([one.first_right or bool(one.pair_found) for one in judgements if one.effect_named]),
        "open > 5": of([one.rejected or one.first_right for one in opened]),
        "area": "–" if area is None else f"{area:.2f}",
        "known unexpl.": of([one.rejected for one in known]),
        "pairs": of([one.pair_found == 2 for one in pairs]),
    }


@click.command(cls=StudyScript)
@click.argument("answers", type=click.Path(path_type=Path))
@click.argument("batches", nargs=-1, type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--frozen", "tiers", type=click.Choice(TIERS), multiple=True, help="Frozen records of this tier, too.")
@click.option("--article", is_flag=True, help="Of the frozen ones only those of the article's test.")
def main(answers: Path, batches: tuple[Path, ...], tiers: tuple[str, ...], article: bool) -> None:
    """Judge the records of BATCHES with one part of the diagnosis taken out at a time."""
    found = all_answers(answers, batches, tiers, article)
    rows = {
        words: figures([judged(truth, answer_of(own[words])) for truth, own in found])
        for words in (*(part.words for part in PARTS), *BASELINES)
    }
    table = Table("taken out", *next(iter(rows.values())), box=box.SIMPLE_HEAD)
    for words, row in rows.items():
        table.add_row(words.replace("_", " "), *row.values())
    wide_console(150).print(table)


if __name__ == "__main__":
    main()
