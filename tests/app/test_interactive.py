"""Wirewear from Python as people write it: values replaced, runs without folders, arrays with units, short words."""

import dataclasses
from pathlib import Path
from typing import Any, cast

import polars as pl
import pytest

import wirewear as ww
from tests.commands import wirewear
from tests.studies import MINIMAL
from tests.synthetic_results import result
from wirewear.app.api.run import distinguished
from wirewear.results import EVOLUTION_COLUMNS, write_result

pytestmark = pytest.mark.seconds
TITANIUM = Path(__file__).parents[2] / "studies" / "atlas" / "arnaud2021" / "record_2Hz"
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
    for values, expected in (
        ({"conditions.normal_load": 4}, "given as normal_load_N"),
        ({"conditions.normal_load_N": "much"}, "must be a number"),
        ({"conditions.normal_load_N.now": 1}, "no table but a value"),
        ({"mesh.scar": 1}, "unknown key 'scar' in \\[mesh\\]"),
        ({"holder.rotational_stiffness_N_mm_per_rad": 1e4}, "pivot_height_mm"),
    ):
        with pytest.raises(ww.StudyError, match=expected):
            study.with_values(values)


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


@pytest.mark.first_case
@pytest.mark.parametrize("form", ["csv", "parquet", "netcdf"])
def test_tables_are_exported_for_other_programs(run: ww.Run, form: str, tmp_path: Path) -> None:
    pytest.importorskip("h5netcdf")
    write_result(tmp_path / "result.h5", run)
    asked = ["export", str(tmp_path / "result.h5"), "--as-tables", str(tmp_path / "out"), "--format", form]
    wirewear(*asked)
    if form == "netcdf":
        import xarray

        with xarray.open_dataset(tmp_path / "out" / "run.nc", group="evolution", engine="h5netcdf") as evolution:
            assert evolution["cycle"].size == run.evolution["cycle"].size
        return
    loops = (pl.read_csv if form == "csv" else pl.read_parquet)(tmp_path / "out" / f"loops.{form}")
    assert loops.filter(pl.col("cycle") == 100)["tangential_force_N"].to_numpy() == pytest.approx(
        run.loop(100).tangential_force_N
    )


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
    assert "at the cycles 1, 100, 1000, 10\u2009000, 100\u2009000<" in record._repr_html_()
    many = dataclasses.replace(record, loops=tuple(dataclasses.replace(record.loops[0], cycle=i) for i in range(1, 14)))
    assert "11, 12 …" in many._repr_html_()


def test_a_record_of_a_line_contact_answers_as_one_of_wires_does(monkeypatch: pytest.MonkeyPatch) -> None:
    record = ww.read_record(TITANIUM)
    assert record.check().supports
    assert f"{len(record.scars)} profiles" in repr(record)
    assert record.name in record._repr_html_()
    asked: list[object] = []

    def remembered(own: object, **options: Any) -> object:
        asked.append(own)
        return options

    monkeypatch.setattr("wirewear.diagnosis.fit.fit_record", remembered)
    monkeypatch.setattr("wirewear.diagnosis.diagnose", remembered)
    assert cast("dict[str, Any]", record.fit(worn_volume_mm3=2.0, progress=False))["given"].volume_mm3 == 2.0
    assert cast("dict[str, Any]", record.diagnose(without=["third_body"]))["left_out"] == ["third_body"]
    assert asked == [record, record]


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


def test_runs_of_one_variant_beside_one_another_are_labelled_by_what_differs(run: ww.Run) -> None:
    study = ww.load(MINIMAL).resolved()
    loads = [
        dataclasses.replace(run, study=study | {"conditions": study["conditions"] | {"normal_load_N": at}})
        for at in (2, 4)
    ]
    assert [one.label for one in distinguished(loads)] == ["compliant, normal load 2 N", "compliant, normal load 4 N"]
    assert [one.label for one in distinguished([run, run])] == ["compliant", "compliant (2)"]
    labels = loads[0].plot(beside=loads[1:]).legends[0].get_texts()
    assert {text.get_text() for text in labels} > {"compliant, normal load 2 N: slip δ0"}


def test_exported_columns_stand_in_their_natural_order(run: ww.Run, tmp_path: Path) -> None:
    run.save(tmp_path / "result.h5")
    columns = ww.read_result(tmp_path / "result.h5").to_polars().columns
    assert tuple(columns[: len(EVOLUTION_COLUMNS)]) == EVOLUTION_COLUMNS


@pytest.mark.seconds
def test_a_line_contact_is_loaded_run_drawn_and_read_as_any_other(tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "studies/cylinder_on_flat/study.toml").read_text(encoding="utf-8")
    short = text.replace("cycles = 10000", "cycles = 2").replace("[1, 100, 1000, 3000, 10000]", "[1, 2]")
    result = ww.run(ww.load(short), fidelity="quick", progress=False)
    assert (result.contact_kind, result.evolution["cycle"][-1]) == ("line-contact", 2)
    assert result.evolution["worn_volume_pad_mm3"][-1] > 0.0
    assert result.to_polars()["cycle"].to_list() == [1, 2]
    assert result.plot().axes
    assert ww.read_result(result.save(tmp_path / "line.h5")).evolution["cycle"][-1] == 2
    with pytest.raises(ww.ResultError, match="line contact"):
        result.surface("pad")
