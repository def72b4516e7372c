"""Scores of several batches side by side, as a table in Markdown.

python -m studies.blind.compare T1/diagnoses T2/diagnoses
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from studies.blind.errors import BlindError
from studies.blind.scoring.table import aim_rows, share_text, words
from wirewear.base.reading import read_json
from wirewear.faces.study_script import StudyScript, understanding


def compared(reports: Sequence[Mapping[str, Any]]) -> str:
    """The aims of T1 and what each batch reached; ✗ marks what misses its aim, (✗) what may do so by chance."""
    rows = [aim_rows(report) for report in reports]
    heads = [f"{report['tier']}, {report['cases']} records" for report in reports]
    lines = [["figure (95 % interval)", "aim of T1", *heads], ["---"] * (2 + len(heads))]
    for same in zip(*rows, strict=True):
        cells = [row.reached + ("" if row.met is not False else " ✗" if row.certain else " (✗)") for row in same]
        lines.append([same[0].what, same[0].aim, *cells])
    for name in sorted({name for report in reports for name in report["baselines"]}):
        for what, figure in (("class right, gaps above 5 scatters", "top1_large"), ("false alarms", "false_alarms")):
            found = [report["baselines"].get(name) for report in reports]
            cells = ["–" if one is None else share_text(one[figure]) for one in found]
            lines.append([f"{words(name)}: {what}", "", *cells])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


@click.command(cls=StudyScript)
@click.argument("scored", nargs=-1, required=True, type=click.Path(exists=True, file_okay=False, path_type=Path))
def main(scored: tuple[Path, ...]) -> None:
    """Print the scores in SCORED, folders with a score.json each, beside each other."""
    reports = []
    for path in (folder / "score.json" for folder in scored):
        report = read_json(path, BlindError, "score")
        with understanding(path, "score of a blind batch"):
            compared([report])
        reports.append(report)
    click.echo(compared(reports))


if __name__ == "__main__":
    main()
