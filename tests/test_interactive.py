"""Wirewear from Python as people write it: values replaced, runs without folders, arrays with units, short words."""

import dataclasses
import inspect
import sys
import types
from pathlib import Path
from typing import Any, cast

import numpy as np
import polars as pl
import pytest
from click.testing import CliRunner

import wirewear as ww
from tests.picture_pixels import shows
from tests.studies import MINIMAL
from tests.synthetic_results import result
from wirewear.base.quantity import unit_of, words_of
from wirewear.faces import cli
from wirewear.faces.bars import NotebookBar, in_notebook
from wirewear.faces.looking import told_apart
from wirewear.fitting import FittedParameter, FittedTest
from wirewear.pictures import save
from wirewear.pictures.colours import VARIANT_COLOURS
from wirewear.pictures.smooth import smooth_loop
from wirewear.pictures.style import cycle_colours
from wirewear.results import EVOLUTION_COLUMNS, LATER_COLUMNS, RunResult, write_result
from wirewear.results import read_result as plain_result
from wirewear.results import read_results as plain_results
from wirewear.results.scar import FIELD_COLUMNS
from wirewear.results.values import LOOP_COLUMNS

TITANIUM = Path(__file__).parents[1] / "studies" / "titanium_oxygenation" / "record_2Hz"

VARIANTS = (
    MINIMAL + "[variants.soft.holder]\ntangential_stiffness_N_per_mm = 167\n[variants.stiff.contact]\nfriction = 0.5\n"
)


@pytest.fixture(scope="module")
def run() -> ww.Run:
    return ww.Run.of(result("compliant", 167.0))


def test_a_study_is_loaded_from_a_path_its_name_or_its_text(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(MINIMAL, encoding="utf-8")
    assert ww.load(path) == ww.load(str(path)) == ww.load(MINIMAL)
    with pytest.raises(ww.StudyError, match=r"missing\.toml"):
        ww.load("missing.toml")


def test_values_are_replaced_and_checked_as_a_file_is() -> None:
    study = ww.load(MINIMAL)
    changed = study.with_values({"conditions.normal_load_N": 4, "wear.energy_wear_coefficient_mm3_per_J": 1e-5})
    assert (study.conditions.normal_load_N, changed.conditions.normal_load_N) == (2.0, 4.0)
    assert changed.wear is not None
    assert changed.with_values({"wear": None}) == study.with_values({"conditions.normal_load_N": 4})
    for values, told in (
        ({"conditions.normal_load": 4}, "given as normal_load_N"),
        ({"conditions.normal_load_N": "much"}, "must be a number"),
        ({"conditions.normal_load_N.now": 1}, "no table but a value"),
        ({"mesh.scar": 1}, "unknown key 'scar' in \\[mesh\\]"),
        ({"holder.rotational_stiffness_N_mm_per_rad": 1e4}, "pivot_height_mm"),
    ):
        with pytest.raises(ww.StudyError, match=told):
            study.with_values(values)


def test_a_test_of_another_length_is_recorded_as_far_as_it_goes() -> None:
    study = ww.load(MINIMAL)
    assert study.with_values({"conditions.cycles": 30}).log.loop_cycles == (1, 2, 5, 10, 20, 30)
    chosen = study.with_values({"log.loop_cycles": [3, 100]})
    assert chosen.with_values({"conditions.cycles": 50}).log.loop_cycles == (3, 50)


def test_a_value_that_variants_state_themselves_is_not_silently_kept() -> None:
    study = ww.load(VARIANTS)
    changed = study.with_values({"conditions.normal_load_N": 4})
    assert [changed.variant(name).conditions.normal_load_N for name in ("soft", "stiff")] == [4.0, 4.0]
    with pytest.raises(ww.StudyError, match=r'stated by its variants soft: take one .* study\.variant\("soft"\)'):
        study.with_values({"holder.tangential_stiffness_N_per_mm": 100})
    alone = study.variant("soft").with_values({"holder.tangential_stiffness_N_per_mm": 100})
    assert (alone.variant_name, alone.holder.tangential_stiffness_N_per_mm) == ("soft", 100.0)


def test_variants_are_run_by_name() -> None:
    with pytest.raises(ww.StudyError, match=r'run\(study\.variant\("soft"\)\)'):
        ww.run(ww.load(VARIANTS))
    with pytest.raises(ww.StudyError, match=r"take run\(study\)"):
        ww.run_variants(ww.load(MINIMAL))
    with pytest.raises(ww.StudyError, match="name it as output"):
        ww.run(ww.load(MINIMAL), resume=True)


@pytest.mark.slow
def test_a_run_needs_no_folder_and_gives_what_a_run_into_one_gives(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    # Coarser than any level: what is asked is whether both ways end alike.
    study = ww.load(MINIMAL).with_values({"conditions.cycles": 1, "fidelity.quick.contact_mesh_um": 20})
    in_memory = ww.run(study, fidelity="quick", progress=False)
    assert list(tmp_path.iterdir()) == []
    assert capsys.readouterr() == ("", "")
    in_folder = ww.run(study, fidelity="quick", output="out")
    for name in EVOLUTION_COLUMNS:
        assert in_memory.evolution[name] == pytest.approx(in_folder.evolution[name], nan_ok=True)
    again = ww.run(study, fidelity="quick", output="out", resume=True, progress=False)
    assert again.timings_s == in_folder.timings_s


def test_arrays_state_their_units(run: ww.Run, tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    tree = run.to_xarray()
    assert tree["evolution"]["slip_amplitude_um"].attrs == {"units": "µm", "long_name": "slip amplitude"}
    loop = tree["loops"].sel(cycle=100)["tangential_force_N"]
    assert loop.values == pytest.approx(run.loop(100).tangential_force_N)
    depth = tree["scars/fixed_100000"]["depth_um"]
    assert float(depth.max()) == pytest.approx(20.0)
    assert depth.sel(axial_um=0, transverse_um=0, method="nearest").item() == pytest.approx(20.0)
    with xarray.open_datatree(run.save(tmp_path / "run.nc"), engine="h5netcdf") as read:
        assert read["scars/fixed_100000"]["pressure_MPa"].attrs["units"] == "MPa"
        assert read["evolution"]["worn_volume_fixed_mm3"].values == pytest.approx(
            run.evolution["worn_volume_fixed_mm3"]
        )


def test_every_column_of_a_result_has_a_unit() -> None:
    names = {*EVOLUTION_COLUMNS, *LATER_COLUMNS, *LOOP_COLUMNS, *FIELD_COLUMNS}
    assert {name for name in names if unit_of(name) == "1"} == {"mirror_error"}
    assert unit_of("energy_density_mJ_per_mm2") == "mJ/mm²"
    assert words_of("worn_volume_fixed_mm3") == "worn volume fixed"


def test_tables_hold_every_sample(run: ww.Run) -> None:
    assert run.to_polars().height == run.evolution["cycle"].size
    assert run.to_polars("loops").height == sum(loop.time_s.size for loop in run.loops)
    scars = run.to_polars("scars")
    deepest = scars.sort("depth_um").row(-1, named=True)
    assert (deepest["wire"], deepest["cycle"]) == ("fixed", 100_000)
    assert (deepest["x_um"], deepest["y_um"]) == pytest.approx((0.0, 0.0), abs=1e-9)
    with pytest.raises(ww.ResultError, match="choose one of evolution, loops, scars"):
        run.to_polars("forces")


@pytest.mark.parametrize("form", ["csv", "parquet", "netcdf"])
def test_tables_are_exported_for_other_programs(run: ww.Run, form: str, tmp_path: Path) -> None:
    pytest.importorskip("h5netcdf")
    write_result(tmp_path / "result.h5", run)
    asked = ["export", str(tmp_path / "result.h5"), "--as-tables", str(tmp_path / "out"), "--format", form]
    told = CliRunner().invoke(cli, asked)
    assert told.exit_code == 0, told.output
    if form == "netcdf":
        import xarray

        with xarray.open_dataset(tmp_path / "out" / "run.nc", group="evolution", engine="h5netcdf") as evolution:
            assert evolution["cycle"].size == run.evolution["cycle"].size
        return
    read = pl.read_csv if form == "csv" else pl.read_parquet
    loops = read(tmp_path / "out" / f"loops.{form}")
    assert loops.filter(pl.col("cycle") == 100)["tangential_force_N"].to_numpy() == pytest.approx(
        run.loop(100).tangential_force_N
    )


def test_an_export_says_where_to(tmp_path: Path) -> None:
    told = CliRunner().invoke(cli, ["export", str(tmp_path / "result.h5")])
    assert (told.exit_code, told.stderr) == (
        2,
        "wirewear: say where to: --as-record DIR, --as-heights DIR, or --as-tables DIR.\n",
    )
    both = ["--as-record", str(tmp_path / "a"), "--as-tables", str(tmp_path / "b")]
    told = CliRunner().invoke(cli, ["export", str(tmp_path / "result.h5"), *both])
    assert told.stderr == ("wirewear: --as-record, --as-heights and --as-tables exclude one another: export again.\n")


def test_a_surface_is_the_worn_wire(run: ww.Run) -> None:
    surface = run.surface("fixed")
    assert surface.bounds[5] > 0.0 > run.surface("moving").bounds[4]
    scar = run.scar(100_000, "fixed")
    x, y = scar.sliding_coordinates(scar.axial_um[:, None], scar.transverse_um[None, :])
    np.testing.assert_allclose(surface.x[..., 0], np.broadcast_to(x, scar.depth_um.shape), atol=1e-4)
    np.testing.assert_allclose(surface.y[..., 0], np.broadcast_to(y, scar.depth_um.shape), atol=1e-4)
    assert surface["depth_um"].reshape(scar.depth_um.shape, order="F") == pytest.approx(scar.depth_um)
    assert float(run.surface("fixed", cycle=100)["depth_um"].max()) < float(surface["depth_um"].max())


def test_a_run_draws_itself_and_others_beside_it(run: ww.Run, tmp_path: Path) -> None:
    picture = save(lambda: run.plot(beside=[result("rigid")]), tmp_path / "overview.png")
    assert shows(picture, *VARIANT_COLOURS[:2])
    assert shows(picture, *cycle_colours(5), part=0.5), "loops stand on the left"
    with pytest.raises(ww.ResultError, match="choose one of overview, loops"):
        run.plot("anything")


def test_words_and_tables_are_short(run: ww.Run) -> None:
    assert repr(run) == "<Run 'compliant', quick, complete: 100\u2009000 cycles, 5 loops, slip 49.6 µm, 20.00 µm deep>"
    page = run._repr_html_()
    assert "<table>" in page
    assert "data:image/png;base64" in page
    assert "  " not in repr(ww.load(MINIMAL))
    assert len(repr(ww.load(MINIMAL))) < 120
    assert "<td" in ww.load(VARIANTS)._repr_html_()


def test_results_are_read_to_be_looked_at(run: ww.Run, tmp_path: Path) -> None:
    write_result(tmp_path / "compliant" / "result.h5", run)
    assert repr(ww.read_result(tmp_path)) == repr(ww.read_result(str(tmp_path / "compliant" / "result.h5")))
    write_result(tmp_path / "rigid" / "result.h5", result("rigid"))
    with pytest.raises(ww.ResultError, match="several runs \\(compliant, rigid\\)"):
        ww.read_result(tmp_path)
    assert [one.variant for one in ww.read_results(tmp_path)] == ["compliant", "rigid"]


def test_a_record_compares_itself(run: ww.Run, tmp_path: Path) -> None:
    stated = ww.load(MINIMAL).with_values({"conditions.cycles": 100_000}).resolved()
    ww.write_record(tmp_path / "record", ww.record_of_result(dataclasses.replace(run, study=stated)))
    record = ww.read_record(tmp_path / "record")
    assert repr(record) == "<Record 'made-up wires, compliant': 1 repeats, 5 loops at 5 cycles, 2 scars>"
    assert not record.check().problems
    assert repr(record.compare(run)).startswith(
        "<RecordComparison of 'compliant' and 'made-up wires, compliant': 5 cycles"
    )
    assert {pair.cycle for pair in record.compare(run).loops} == {1, 100, 1000, 10_000, 100_000}
    assert "<table>" in record._repr_html_()


def test_a_record_is_fitted_and_the_fit_is_a_table(
    run: ww.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stated = ww.load(MINIMAL).with_values({"conditions.cycles": 100_000})
    of_study = dataclasses.replace(run, study=stated.resolved())
    record = ww.read_record(ww.write_record(tmp_path / "record", ww.record_of_result(of_study)))
    stiffness = FittedParameter(167.3, (160.0, 174.6), "N_per_mm", 1)

    def fit_record(told: ww.ExperimentRecord, **options: Any) -> FittedTest:
        with options["observer_of"]("nominal"):
            return FittedTest(told, stated, {"tangential_stiffness_N_per_mm": stiffness}, {})

    monkeypatch.setattr("wirewear.fitting.fit_record", fit_record)
    fitted = record.fit(progress=False)
    assert repr(fitted) == "<Fit of 'made-up wires, compliant': tangential_stiffness_N_per_mm = 167.3>"
    assert "167.3 (160 to 174.6) N/mm" in fitted._repr_html_()


def test_a_record_of_a_line_contact_answers_as_one_of_wires_does(monkeypatch: pytest.MonkeyPatch) -> None:
    record = ww.read_line_record(TITANIUM)
    assert record.check().supports
    assert f"{len(record.profiles)} profiles" in repr(record)
    assert record.name in record._repr_html_()
    asked: list[object] = []

    def remembered(told: object, **options: Any) -> object:
        asked.append(told)
        return options

    monkeypatch.setattr("wirewear.fitting.fit_record", remembered)
    monkeypatch.setattr("wirewear.diagnosis.diagnose", remembered)
    assert cast("dict[str, Any]", record.fit(worn_volume_mm3=2.0, progress=False))["given"].volume_mm3 == 2.0
    assert cast("dict[str, Any]", record.diagnose(without=["third_body"]))["left_out"] == ["third_body"]
    assert asked == [record, record]


def test_a_record_of_wires_is_refused_as_one_of_a_line_contact() -> None:
    with pytest.raises(ww.RecordError):
        ww.read_line_record(TITANIUM.parents[1] / "steel_wires" / "example_records" / "no_gap")


@pytest.fixture
def notebook(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """A kernel that keeps what is shown, each entry what stands in the place of the bar."""
    drawn: list[str] = []
    shell = type("ZMQInteractiveShell", (), {})()
    place = types.SimpleNamespace(update=drawn.append)

    def display(shown: str, **_: Any) -> Any:
        drawn.append(shown)
        return place

    module = types.ModuleType("IPython.display")
    module.HTML, module.display = str, display  # type: ignore[attr-defined]
    ipython = types.ModuleType("IPython")
    ipython.get_ipython = lambda: shell  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", module)
    return drawn


def test_a_notebook_shows_how_far_a_run_is(notebook: list[str]) -> None:
    from wirewear.simulation import Moment

    assert in_notebook()
    with NotebookBar("steel <wires>") as bar:
        bar.stage("condensing the wires")
        bar.moved(Moment(50.0, 100, 1.5, 2.0, 0.5, 3.0))
        bar.note("something to know")
    assert "steel &lt;wires&gt;" in notebook[0]
    assert "condensing" in notebook[1]
    assert "value='0.5000'" in notebook[-1]
    assert "cycle 50 of 100, 1.5 J, 2.00 µm deep" in notebook[-1]
    assert "something to know" in notebook[-1]


def test_a_smooth_loop_passes_through_its_samples_and_never_beyond(run: ww.Run) -> None:
    loop = run.loop(100_000)
    x, q = smooth_loop(loop)
    assert (x[0], q[0]) == (x[-1], q[-1])
    assert np.ptp(x) == pytest.approx(np.ptp(loop.displacement_um))
    assert np.ptp(q) == pytest.approx(np.ptp(loop.tangential_force_N))
    distance = np.hypot(x[:, None] - loop.displacement_um, q[:, None] - loop.tangential_force_N).min(axis=0)
    assert distance.max() < 1e-9


def test_a_fidelity_that_there_is_not_is_answered_with_those_there_are() -> None:
    with pytest.raises(ww.StudyError, match="no fidelity 'fast': choose one of quick, standard, fine"):
        ww.run(ww.load(MINIMAL), fidelity="fast")


def test_a_column_that_there_is_not_is_answered_with_those_like_it(run: ww.Run) -> None:
    with pytest.raises(ww.ResultError, match=r"^evolution has no column 'slip': there is slip_amplitude_um$"):
        run.evolution["slip"]
    with pytest.raises(KeyError, match="there is cycle, displacement_amplitude_um, slip_amplitude_um"):
        run.evolution["friction"]
    assert "slip" not in run.evolution
    assert run.evolution.get("slip") is None


def test_runs_of_one_variant_beside_one_another_are_told_apart_by_what_differs(run: ww.Run) -> None:
    study = ww.load(MINIMAL).resolved()
    loads = [
        dataclasses.replace(run, study=study | {"conditions": study["conditions"] | {"normal_load_N": at}})
        for at in (2, 4)
    ]
    assert [one.label for one in told_apart(loads)] == ["compliant, normal load 2 N", "compliant, normal load 4 N"]
    assert [one.label for one in told_apart([run, run])] == ["compliant", "compliant (2)"]
    labels = loads[0].plot(beside=loads[1:]).legends[0].get_texts()
    assert {text.get_text() for text in labels} > {"compliant, normal load 2 N: slip δ0"}


def test_exported_columns_stand_in_their_natural_order(run: ww.Run, tmp_path: Path) -> None:
    run.save(tmp_path / "result.h5")
    columns = ww.read_result(tmp_path / "result.h5").to_polars().columns
    assert tuple(columns[: len(EVOLUTION_COLUMNS)]) == EVOLUTION_COLUMNS


def test_whatever_takes_a_path_takes_its_text() -> None:
    offered = {name: getattr(ww, name) for name in ww.__all__}
    functions: dict[str, Any] = {name: one for name, one in offered.items() if inspect.isfunction(one)}
    for name, kind in offered.items():
        if inspect.isclass(kind):
            methods = inspect.getmembers(kind, inspect.isfunction)
            functions |= {f"{name}.{own}": one for own, one in methods if not own.startswith("_")}
    taking = {
        f"{name}({one.name})": str(one.annotation)
        for name, function in functions.items()
        for one in inspect.signature(function).parameters.values()
        if "Path" in str(one.annotation)
    }
    assert {"load(source)", "read_results(path)", "run_study(output)", "write_result(path)", "Run.save(path)"} <= {
        *taking
    }
    assert [name for name, annotation in taking.items() if "str" not in annotation] == []


def test_results_are_written_and_read_by_the_text_of_a_path(tmp_path: Path) -> None:
    ww.write_result(str(tmp_path / "run" / "result.h5"), result())
    read: list[RunResult] = [ww.read_result(str(tmp_path / "run")), *ww.read_results(str(tmp_path))]
    read += [plain_result(str(tmp_path / "run" / "result.h5")), *plain_results(str(tmp_path))]
    assert [one.name for one in read] == 4 * [result().name]


def test_a_wire_that_there_is_not_is_named_with_those_there_are(run: ww.Run) -> None:
    for asked in (lambda: run.surface("left"), lambda: run.forces(1, "left")):
        with pytest.raises(ww.ResultError, match="wire must be one of moving, fixed, not 'left'"):
            asked()
