"""Results that earlier versions wrote are read as those of today."""

import io
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.synthetic_results import earlier_line_result
from wirewear.base.hdf5 import hdf5_image
from wirewear.results import Evolution, RunResult, read_result, write_result
from wirewear.results.flat import evolution_table, loops_table, profiles_table


@pytest.fixture
def earlier(tmp_path: Path) -> RunResult:
    """200 cycles of a cylinder on a flat: 100 N/mm, friction 0.6, wear 2 and 4 times 10⁻⁵ mm³/J, a tilting holder."""
    (tmp_path / "earlier.h5").write_bytes(earlier_line_result())
    return read_result(tmp_path / "earlier.h5")


def test_a_line_contact_of_the_earlier_format_obeys_coulomb_and_its_wear_law(earlier: RunResult) -> None:
    evolution, energy_J = earlier.evolution, earlier.evolution["accumulated_energy_J"]
    assert (earlier.contact_kind, earlier.status, earlier.length_mm) == ("line-contact", "complete", 1.0)
    assert evolution["max_tangential_force_N"] == pytest.approx(60.0, rel=1e-3)
    for body, coefficient in (("pad", 2e-5), ("specimen", 4e-5)):
        assert evolution[f"worn_volume_{body}_mm3"] == pytest.approx(coefficient * energy_J, rel=1e-6)
        assert earlier.scar(200, body).volume_mm3 == pytest.approx(evolution[f"worn_volume_{body}_mm3"][-1], rel=1e-9)
        assert earlier.scar(200, body).pressure_MPa.max() == pytest.approx(
            evolution["mid_stroke_pressure_MPa"][-1], rel=0.02
        )


def test_tables_of_a_line_contact_are_per_mm_whatever_its_length(earlier: RunResult) -> None:
    """The names are those that its earlier file has."""
    with h5py.File(io.BytesIO(earlier_line_result())) as file:
        written = {name: column[()] for name, column in file["evolution"].items()}
    for result in (earlier, earlier.of_length(7.0)):
        table = evolution_table(result)
        for name, column in written.items():
            assert table[name].to_numpy() == pytest.approx(column, rel=1e-12), name
        assert loops_table(result)["tangential_force_N_per_mm"].max() == pytest.approx(60.0, rel=1e-3)
    assert profiles_table(earlier).columns[:4] == ["cycle", "body", "x_um", "depth_um"]
    longer = earlier.of_length(7.0)
    assert longer.loop(200).tangential_force_N == pytest.approx(7.0 * earlier.loop(200).tangential_force_N)
    assert longer.worn_volume_mm3 == pytest.approx(7.0 * earlier.worn_volume_mm3)
    assert longer.scar(200, "pad").volume_mm3 == pytest.approx(7.0 * earlier.scar(200, "pad").volume_mm3)


def test_what_the_first_format_of_line_contacts_lacks_is_unknown(tmp_path: Path) -> None:
    """It has neither normal force, tilt nor slip, and none of the columns that came later."""
    later = ("loops/{}/tilt_deg", "loops/{}/normal_force_N_per_mm", "profiles/{}/slip_amplitude_um")

    def fill(file: h5py.File) -> None:
        with h5py.File(io.BytesIO(earlier_line_result())) as before:
            for name in before:
                before.copy(name, file)
            file.attrs.update(before.attrs)
        file.attrs["format"] = 1
        for index, pattern in [(index, pattern) for pattern in later for index in ("0000", "0001")]:
            del file[pattern.format(index)]
        for name in ("normal_force_N_per_mm", "displacement_amplitude_um", "mirror_error"):
            del file["evolution"][name]

    (tmp_path / "first.h5").write_bytes(hdf5_image(fill))
    result = read_result(tmp_path / "first.h5")
    assert all(np.isnan(loop.normal_force_N).all() and np.isnan(loop.tilt_deg).all() for loop in result.loops)
    assert np.isnan(result.evolution["normal_force_N"]).all()
    assert result.evolution["max_tangential_force_N"] == pytest.approx(60.0, rel=1e-3)


def test_columns_of_an_evolution_keep_their_order_in_a_file(earlier: RunResult, tmp_path: Path) -> None:
    """A run that goes on from its file writes the same tables as one that nothing stopped."""
    turned = Evolution({name: earlier.evolution[name] for name in reversed(list(earlier.evolution))})
    assert list(turned) != list(earlier.evolution)
    write_result(tmp_path / "result.h5", replace(earlier, evolution=turned))
    assert list(read_result(tmp_path / "result.h5").evolution) == list(turned)
