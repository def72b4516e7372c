"""Command on a campaign: all tests of a rig in one folder."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wirewear.app.cli.group import Given, OutputFolder, busy, cli, most_memory, stage
from wirewear.base.errors import RunError, WirewearError
from wirewear.base.files import kept_table
from wirewear.base.writing import json_text, write_text

if TYPE_CHECKING:
    from wirewear.comparison.campaign import CampaignResult
    from wirewear.records import AnyRecord
    from wirewear.records.importing.campaign import CampaignTest

JOURNAL = "lab.json"  #: What each test's files were when it was last looked at.


@cli.command()
@click.argument("folder", metavar="FOLDER", type=Given())
@click.option("--output", metavar="DIR", required=True, type=OutputFolder())
@click.option("--diagnose", is_flag=True, help="Diagnose each test, too, which takes some 10 to 40 s a test.")
@click.option("--json", "as_json", is_flag=True, help="Print the tests as JSON.")
@most_memory
def lab(folder: Path, output: Path, diagnose: bool, as_json: bool) -> None:
    """Import all tests of a folder by one mapping, check them and set them side by side.

    In the mapping's file names, {test} stands for the test. What differs between tests, such as the load, stands in
    tests.csv. Given again, the command takes up what is new or has changed.
    """
    from wirewear.app.cli.consoles import wide_console
    from wirewear.base.locks import occupied
    from wirewear.comparison.campaign import with_outliers
    from wirewear.records.importing.campaign import campaign_tests
    from wirewear.views.campaign_page import campaign_json, campaign_table, said_of, sentences, write_campaign

    tests = campaign_tests(folder)
    if output.resolve().is_relative_to(folder.resolve()):
        raise RunError(f"{output} lies in the folder of the campaign, among its files: choose another --output.")
    with occupied(output, f"lab {folder}"):
        journal, found = kept_table(output / JOURNAL), []
        for one in tests:
            found.append(_looked_at(folder, output, one, journal, diagnose=diagnose))
            write_text(output / JOURNAL, json_text(journal) + "\n")
        found = with_outliers(found)
        with busy("writing the page"):
            written = write_campaign(found, folder, output)
    if as_json:
        click.echo(json_text(campaign_json(found)))
        return
    wide_console(150).print(campaign_table(found))
    for sentence in sentences(found):
        click.echo(sentence)
    for test in found:
        if test.answer:
            click.echo(f"{test.name}: {test.answer}")
    for name, text in said_of(found):
        click.echo(f"wirewear: {name}: {text}", err=True)
    for path in written:
        click.echo(path)


def _looked_at(
    folder: Path, output: Path, test: CampaignTest, journal: dict[str, Any], *, diagnose: bool
) -> CampaignResult:
    """A test imported, checked and, if asked for, diagnosed; what is kept of an earlier time with the same files is not
    computed again. `journal` is brought up to date.
    """
    from wirewear.comparison.campaign import CampaignResult
    from wirewear.comparison.mapped_tests import fretting_test
    from wirewear.records import check_record, read_record, write_record
    from wirewear.records.importing import import_record
    from wirewear.records.importing.campaign import MAPPING, why_refused
    from wirewear.records.importing.importing import inputs_of

    record_path, known = output / "records" / test.name, journal.get(test.name, {})
    try:
        mapping = folder / MAPPING
        digest = _digest(inputs_of(mapping, test), test)
        if known.get("files") != digest or not record_path.is_dir():
            known = {"files": digest}
            with busy(f"reading {test.name}"):
                record_path.parent.mkdir(parents=True, exist_ok=True)
                imported = import_record(mapping, test)
                known["notes"] = list(imported.notes)
                write_record(record_path, imported, overwrite=True)
        record = read_record(record_path)
        problems = tuple(remark.text for remark in check_record(record).problems)
        mapped = fretting_test(record, record_path)
        if diagnose and not problems and "answer" not in known:
            known["answer"] = _diagnosed(record, output / "diagnoses" / test.name)
        notes = tuple(known.get("notes", ()))
        surfaces = tuple(own[0] for body in record.tables.body_names if (own := record.scars_of(body)))
        return CampaignResult(
            test.name, mapped, problems=problems, notes=notes, answer=known.get("answer", ""), surfaces=surfaces
        )
    except WirewearError as refusal:
        return CampaignResult(test.name, refused=why_refused(folder, test, str(refusal)))
    finally:
        journal[test.name] = known


def _diagnosed(record: AnyRecord, folder: Path) -> str:
    """The sentence of a record's diagnosis, whose report is written to a folder."""
    from wirewear.diagnosis import diagnose_prepared, prepared
    from wirewear.simulation import ProgressBar
    from wirewear.views.diagnosis_page import write_diagnosis

    records = prepared(record.of_block(), None, [])
    diagnosed = diagnose_prepared(records, observer_of=ProgressBar, left_out=(), stage=stage)
    write_diagnosis(diagnosed, folder)
    return diagnosed.diagnosis.sentence


def _digest(files: list[Path], test: CampaignTest) -> str:
    found = hashlib.sha256(json.dumps(dict(test.stated), sort_keys=True).encode())
    for path in files:
        found.update(path.read_bytes())
    return found.hexdigest()
