"""Wrong files, folders and options over all commands: one sentence, exit code 2, nothing computed before it."""

import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import click
import pytest
from click.testing import CliRunner, Result

from studies.blind.commands import exam
from tests import synthetic_results
from tests.studies import MINIMAL, minimal
from tests.synthetic_results import result
from wirewear import RunError, StudyError, write_result
from wirewear.app.cli import cli
from wirewear.app.cli.group import OutputFile, OutputFolder
from wirewear.test import parse_study

STUDIES = Path(__file__).parents[2] / "studies"
RECORD = STUDIES / "steel_wires" / "example_records" / "no_gap"


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with one of everything, among them files that are nothing."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text").write_text("hello\n", encoding="utf-8")
    (tmp_path / "bytes").write_bytes(bytes(range(256)))
    (tmp_path / "folder").mkdir()
    for name in ("steel_wires", "cylinder_on_flat"):
        shutil.copy(STUDIES / name / "study.toml", tmp_path / f"{name}.toml")
    write_result(tmp_path / "result.h5", synthetic_results.result())
    (tmp_path / "planar.h5").write_bytes(synthetic_results.earlier_line_result())
    shutil.copy(RECORD / "loops.csv", tmp_path)
    return tmp_path


def invoked(line: str) -> Result:
    words = [str(RECORD) if word == "RECORD" else word for word in line.split()]
    return CliRunner().invoke(exam, words[1:]) if words[0] == "blind" else CliRunner().invoke(cli, words)


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("diagnose RECORD --model cylinder_on_flat.toml --output d", 'a study of kind "cylinder-on-flat"'),
        ("check nowhere", "nowhere does not exist: a record is a folder with experiment.toml and CSV files."),
        ("diagnose text --output d", "text is a file: a record is a folder with experiment.toml and CSV files."),
        ("import folder --output d", "folder is a folder, where a TOML file is needed."),
        ("show text", "text is no wirewear result file.\n"),
        ("loops text", "text: no table of numbers is found in its first 200 lines."),
        ("loops RECORD --variant one", "--variant chooses among the runs of a result, which "),
        ("loops RECORD --cycle 100 --output x.xyz", "x.xyz cannot be drawn: its name must end in .png, .svg or .pdf."),
        ("loops RECORD --cycle 100 --output text/x.png", "the output folder text cannot be used: it is a file, not a"),
        ("loops loops.csv --encoding zlib", "invalid value for '--encoding': 'zlib' is no encoding such as utf-8 or"),
        ("verify --quick --json text/x.json", "the output folder text cannot be used: it is a file, not a folder."),
        (
            "compare planar.h5 RECORD --output c",
            "planar.h5 is a result of a line contact, where one of crossed wires is",
        ),
        ("strength result.h5 --output text", "the output folder text cannot be used: it is a file, not a folder."),
        ("blind make b --cases 1 --seed 1 --key text/key", "the output folder text cannot be used: it is a file, not"),
        (
            "blind make b --cases 1 --seed 1 --key text",
            "the key file text exists already, and no key is replaced: name",
        ),
        ("show result.h5 --output text/pictures", "a part of this path is a file, not a folder"),
        (
            "export result.h5 --as-record a --as-tables b",
            "--as-record, --as-heights, --as-tables and --as-deck exclude one another",
        ),
        (
            "export result.h5 --as-record a --variant b",
            "there is no variant 'b' in result.h5, which holds a run without",
        ),
        (
            "export result.h5 --as-record a --noise x=1",
            "--noise holds 'x=1', but must be a list like displacement_um=0.1",
        ),
        ("export result.h5 --as-record a --length 2", "--length does not apply to"),
        (
            "fit RECORD --output f --wear-coefficient 1e-4 --worn-volume 1e-3",
            "give either --wear-coefficient or --worn",
        ),
        ("new --mapping loops.csv nowhere.csv", "nowhere.csv"),
        ("effects --plot", "--plot needs the name of an effect: `wirewear effects` lists them."),
        ("run steel_wires.toml --uncertain --json", "--json does not go with --uncertain."),
        ("report folder", "there is no result.h5 in folder or in a folder directly below it."),
    ],
)
def test_a_wrong_input_is_one_sentence_and_exit_code_2(line: str, sentence: str) -> None:
    ended = invoked(line)
    assert ended.exit_code == 2, ended.output
    assert sentence in ended.stderr
    assert ended.stderr.strip().isprintable()


@pytest.mark.parametrize("output", ["text", "text/deeper", "/proc/nowhere"])
@pytest.mark.parametrize(
    "line",
    [
        "run steel_wires.toml",
        "run steel_wires.toml --variant rigid --resume",
        "run cylinder_on_flat.toml",
        "converge steel_wires.toml --variant rigid",
        "effects free_play --plot",
        "diagnose RECORD",
        "calibrate steel_wires.toml --variant rigid --record RECORD",
    ],
)
def test_an_output_that_takes_no_files_is_refused_at_once(
    line: str, output: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def forbidden(*_: object) -> None:
        raise AssertionError("a body was condensed")

    for place in ("wirewear.simulation.problem.condensed_body", "wirewear.simulation.line_model.condense"):
        monkeypatch.setattr(place, forbidden)
    ended = invoked(f"{line} --output {output}")
    assert ended.exit_code == 2, ended.output
    assert f"the output folder {output}" in ended.stderr
    assert ended.stderr.strip().endswith(".")
    assert not Path("runs").exists()


def commands(group: click.Command, before: str = "") -> dict[str, click.Command]:
    """All commands by what is typed."""
    if not isinstance(group, click.Group):
        return {before: group}
    return {
        name: own
        for word, command in group.commands.items()
        for name, own in commands(command, f"{before} {word}".strip()).items()
    }


#: Output paths of commands by the commands that do not try them first: what lists effects writes nothing.
NOT_TRIED = {("effects", "output")}


def outputs() -> list[tuple[str, click.Parameter]]:
    """Every parameter that may name what a command writes."""
    return [
        (name, parameter)
        for name, command in commands(cli).items()
        for parameter in command.params
        if isinstance(parameter.type, click.Path)
        and ("output" in str(parameter.name) or {"--json", "--as-record", "--as-tables"} & set(parameter.opts))
        and (name, parameter.name) not in NOT_TRIED
    ]


LONG = "n" * 300


@pytest.mark.parametrize("given", ["text/deeper", "/proc/nowhere/deeper", LONG, f"nowhere/{LONG}"])
def test_an_output_that_cannot_be_written_is_refused_while_the_command_is_read(given: str, tmp_path: Path) -> None:
    before = sorted(tmp_path.iterdir())
    for command, parameter in outputs():
        assert isinstance(parameter.type, OutputFile | OutputFolder), command
        with pytest.raises(RunError, match=r"(cannot be used|cannot be written): .*[a-z]\.$"):
            parameter.type_cast_value(click.Context(cli), given)
    assert sorted(tmp_path.iterdir()) == before


def refused(*arguments: str | Path) -> str:
    """The sentence of a command that refuses."""
    ended = CliRunner().invoke(cli, [str(argument) for argument in arguments])
    assert ended.exit_code == 2, ended.output or ended.exception
    (sentence,) = [line for line in ended.stderr.splitlines() if line.startswith("wirewear: ")]
    assert sentence.endswith(".")
    return sentence


@pytest.fixture
def run(tmp_path: Path) -> Path:
    write_result(tmp_path / "run" / "result.h5", replace(result(), study=minimal()))
    return tmp_path / "run"


@pytest.mark.parametrize("value", ["nan", "inf", "-1", "many"])
@pytest.mark.parametrize(
    "command",
    [
        ["fields", "run", "--cycle"],
        ["strength", "run", "--cycle"],
        ["strength", "run", "--yield-strength"],
        ["strength", "run", "--averaging-length"],
        ["fit", "record", "--output", "o", "--wear-coefficient"],
        ["fit", "record", "--output", "o", "--worn-volume"],
        ["export", "run", "--as-record", "o", "--length"],
        ["maps", "record", "--fatigue-limit"],
        ["calibrate", "study.toml", "--remote-compliance"],
        ["run", "study.toml", "--most-memory"],
    ],
)
def test_what_is_no_number_of_its_range_is_refused(command: Sequence[str], value: str) -> None:
    assert f"'{command[-1]}'" in refused(*command, value)


@pytest.mark.parametrize("options", [["--integration-points"], ["--no-pictures"]])
def test_options_of_wires_are_refused_for_lines(
    options: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("wirewear.app.api.run.one_run", lambda _: Mock(length_mm=1.0, contact_kind="line-contact"))
    assert f"{options[0]} does not apply to" in refused("fields", tmp_path, "--cycle", "1", *options)


@pytest.mark.parametrize(
    ("line", "says"),
    [
        (
            "--diameter 1200",
            "--diameter is 1200.0, but must lie between 0.02 and 20 millimetres: it looks like micrometres",
        ),
        ("--diameter 450e-6", "it looks like metres, which would be 0.45 here"),
        ("--diameter 0.45 --normal-load 20000", "it looks like millinewtons, which would be 20 here"),
        ("--diameter 0.45 --amplitude 0.06", "it looks like millimetres, which would be 60 here"),
        ("--diameter 0,45", "'0,45' is no number: a point is the decimal sign, as in 0.45."),
        ("--cycles 1e4", "'1e4' is no whole number, such as 20."),
        ("--diameter nan", "--diameter is nan, but must be a finite number"),
        ("--length 10 --radius 40000", "--radius is 40000.0, but must lie between"),
    ],
)
def test_what_is_stated_of_a_test_in_another_unit_is_refused(line: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "loops.csv").write_text("x,q\n1,2\n")
    assert says in refused("new", "--mapping", tmp_path / "loops.csv", *line.split())
    assert not (tmp_path / "mapping.toml").exists()


@pytest.mark.parametrize("command", [["strength", "--yield-strength"], ["maps", "--fatigue-limit"]])
def test_a_strength_in_gigapascals_is_refused(command: list[str], run: Path) -> None:
    name, option = command
    assert "it is 0.3, but must lie between 5 and 10000 megapascals: it looks like gigapascals, which would be 300" in (
        refused(name, run, option, "0.3")
    )


#: What stands in the smallest study => what stands there instead; below it what is said.
MISTAKES = r"""
normal_load_N = 2.0 => normal_load_kN = 0.002
    unknown key 'normal_load_kN' in [conditions] of s.toml: the normal load between the bodies is given as
    normal_load_N, in newtons.
diameter_mm = 0.45 => diameter_um = 450
    unknown key 'diameter_um' in [wires] of s.toml: the diameter of the wires is given as diameter_mm, in millimetres.
diameter_mm = 0.45 => diameter_mm = 450
    diameter_mm in [wires] of s.toml is 450, but must lie between 0.02 and 20 millimetres: it looks like micrometres,
    which would be 0.45 here.
friction = 0.62 => friction = -0.62
    friction in [contact] of s.toml is -0.62, but must lie between 0 and 2.
friction = 0.62 => friction = nan
    friction in [contact] of s.toml is nan, but must be a finite number between 0 and 2.
friction = 0.62 => friction = "0.62"
    friction in [contact] of s.toml is the text '0.62', but must be a number between 0 and 2: write it without quotes,
    0.62.
friction = 0.62 =>
    missing key 'friction' in [contact] of s.toml: give the coefficient of friction, for example friction = 0.62.
[contact]\nfriction = 0.62 =>
    missing table [contact] in s.toml: it must give friction.
friction = => frction =
    unknown key 'frction' in [contact] of s.toml: did you mean 'friction'?
[contact] => moving_share = 0.5\n[contact]
    unknown key 'moving_share' in [conditions] of s.toml: it belongs in [wear].
friction = 0.62 => friction = 0.62\ncolour = 1
    unknown key 'colour' in [contact] of s.toml: the keys known there are friction, friction_law, plasticity,
    formulation, primary_wire.
cycles = 700 => cycles = 7.5
    cycles in [conditions] of s.toml is 7.5, but must be a whole number between 1 and 1000000000 cycles.
displacement_amplitude_um = 60.0 => stroke_um = 120
    unknown key 'stroke_um' in [conditions] of s.toml: give displacement_amplitude_um, the imposed displacement
    amplitude, half the stroke.
friction = 0.62 => frction = 0.62\ncolour = 1
    unknown key 'frction' in [contact] of s.toml: did you mean 'friction'? Unknown key 'colour' in [contact] of s.toml:
    the keys known there are friction, friction_law, plasticity, formulation, primary_wire.
[contact] => [bodies.moving]\n[contact]
    unknown key 'bodies' in s.toml: one wire alone is [wires.moving] or [wires.fixed].
friction = 0.62 => friction = 0.62\ncolour = 1\nnoise = 2
    unknown key 'colour' in [contact] of s.toml: the keys known there are friction, friction_law, plasticity,
    formulation, primary_wire. Unknown key 'noise' in [contact] of s.toml.
friction = 0.62 => friction = 0.62\nfriction = 0.5
    s.toml is not valid TOML: cannot overwrite a value (at line 15, column 15): friction was given before.
friction = 0.62 => friction = 0,62
    s.toml is not valid TOML: expected newline or end of document after a statement (at line 14, column 13); the decimal
    sign is a point: friction = 0.62.
normal_load_N = 2.0 => normal_load_N = 2.0 N
    s.toml is not valid TOML: expected newline or end of document after a statement (at line 9, column 21); the unit
    stands in the key's name: normal_load_N = 2.0.
kind = "crossed-wires" => kind = crossed-wires
    s.toml is not valid TOML: invalid value (at line 1, column 8); a text stands in quotes: kind = "crossed-wires".
displacement_amplitude_um = 60.0 => displacement_amplitude_um = 600.0
    displacement_amplitude_um in [conditions] of s.toml is 600 µm, but must not exceed the smallest diameter, 450 µm.
[contact] => [log]\nloop_cycles = [1, 0]\n[contact]
    loop_cycles in [log] of s.toml holds an item that is 0, but must lie between 1 and 1000000000 cycles.
[contact] => [log]\nloop_cycles = 3\n[contact]
    loop_cycles in [log] of s.toml is 3, but must be a list of cycle numbers such as [1, 100, 1000].
[contact] => [wires.moving]\nlength_mm = 0.4\n[contact]
    length_mm in [wires.moving] of s.toml is 0.4 mm, but must be at least the wire's diameter, 0.45 mm.
[contact] => [fidelity.quick]\nincrements_per_cycle = 30\n[contact]
    increments_per_cycle in [fidelity.quick] of s.toml is 30, but must be a whole number that is a multiple of 4 between
    16 and 4000.
[contact] => [fidelity.fine]\ncontact_mesh_um = 9\nouter_mesh_um = 3\n[contact]
    contact_mesh_um in [fidelity.fine] of s.toml is 9 µm, but must not exceed outer_mesh_um = 3 µm.
[contact] => [variants.a.holder]\ntangential_stiffness_N_per_mm = "rigd"\n[contact]
    tangential_stiffness_N_per_mm in [variants.a.holder] of s.toml is the text 'rigd', but must be a number between 1
    and 10000000 newtons per millimetre, or "rigid".
[contact] => [variants.a]\nfriction = 1\n[contact]
    'friction' in [variants.a] of s.toml is 1, but a variant holds only tables such as [variants.a.holder].
[contact] => [variants."../a".holder]\n[contact]
    the variant '../a' in s.toml needs another name: letters, digits, _ and - only, 64 at most.
kind = "crossed-wires" => kind = "crossed-wires"\nvariants = 3
    variants in s.toml is 3, but must hold tables like [variants.rigid.holder].
format = 1 => format = 2
    format in s.toml is 2, but this version of wirewear reads format 1.
kind = "crossed-wires" => kind = "planar"
    kind in s.toml is 'planar', but must be "crossed-wires"; `wirewear run` also takes "ball-on-flat" or "point-contact"
    or "line-contact" or "cylinder-on-flat".
kind = "crossed-wires" => kind = "cylinder-on-flat"
    s.toml is a study of kind "cylinder-on-flat", which is not taken here: give one of kind "crossed-wires".
friction = 0.62 => friction = 1979-05-27
    friction in [contact] of s.toml is 1979-05-27, but must be a number between 0 and 2.
name = "test" => name = 3
    name in s.toml is 3, but must be a text such as "steel wires".
"""


def mistakes() -> list[tuple[str, str, str]]:
    """Old and new text and the sentence of each mistake."""
    found: list[list[str]] = []
    for line in MISTAKES.strip().splitlines():
        if line.startswith(" "):
            found[-1][2] = f"{found[-1][2]} {line.strip()}".strip()
        else:
            found.append([*(part.strip().replace(r"\n", "\n") for part in line.split("=>")), ""])
    return [(old, new, sentence) for old, new, sentence in found]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        *mistakes(),
        (
            "cycles = 700",
            f"cycles = {'9' * 5000}",
            "s.toml is not valid TOML: a number is too long or the nesting too deep.",
        ),
        (
            "cycles = 700",
            f"cycles = 0x{'f' * 5000}",
            (
                "cycles in [conditions] of s.toml is a number of thousands of digits, but must lie between 1 and "
                "1000000000 cycles."
            ),
        ),
    ],
)
def test_a_mistake_is_stated_with_its_place_and_what_would_be_right(old: str, new: str, message: str) -> None:
    assert MINIMAL.count(old) == 1
    with pytest.raises(StudyError) as caught:
        parse_study(MINIMAL.replace(old, new), "s.toml")
    assert str(caught.value) == message
