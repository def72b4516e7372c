"""Results: what they accept and answer; their files are read as written, also by earlier versions, or refused."""

import dataclasses
import io
import math
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tests.synthetic_results import bowl, earlier_line_result, result
from wirewear.base.errors import ResultError
from wirewear.base.hdf5 import hdf5_image, sealed
from wirewear.results import EVOLUTION_COLUMNS, Evolution, Loop, RunResult, Scar, read_result, write_result
from wirewear.results.export import evolution_table, loops_table, profiles_table, write_time_series
from wirewear.results.scar import WIRES, body_named
from wirewear.results.values import PlasticStrain


@pytest.mark.parametrize(
    "bodies", [WIRES, ("flat", "ball"), ("specimen", "pad"), ("lower", "upper"), ("held", "lower")]
)
def test_bodies_are_found_by_their_names_and_by_how_they_stand(bodies: tuple[str, str]) -> None:
    driven, held = bodies
    assert [body_named(one, "run", bodies) for one in bodies] == list(bodies)
    for names, body in ((("lower", "driven", "moving"), driven), (("upper", "held", "fixed"), held)):
        assert {body_named(name, "run", bodies) for name in names if name not in bodies} == {body}
    with pytest.raises(ResultError, match=f"^run: the body must be one of {driven}, {held}, or lower or upper, not"):
        body_named("middle", "run", bodies)


def test_every_logged_scar_is_a_surface_that_its_pvd_file_lists_by_cycle(tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    run = result(milestones=(100, 1_000, 100_000))
    paths = write_time_series(run, tmp_path / "vtk")
    assert [path.name for path in paths] == ["scar_moving.pvd", "scar_fixed.pvd"]
    for path, upward in zip(paths, (1.0, -1.0), strict=True):
        scars = [scar for scar in run.scars if f"scar_{scar.body}.pvd" == path.name]
        sets = ET.parse(path).getroot().findall("./Collection/DataSet")
        assert [float(item.attrib["timestep"]) for item in sets] == [scar.cycle for scar in scars]
        for item, scar in zip(sets, scars, strict=True):
            surface = pyvista.read(path.parent / item.attrib["file"])
            assert surface.n_points == scar.depth_um.size
            assert surface.point_data["depth_um"] == pytest.approx(scar.depth_um.ravel())
            assert upward * surface.points[:, 2].max() <= 1e-6 or upward < 0.0
            # The crown is where the surface is least worn or unworn: worn points lie below it.
            deepest = int(np.argmax(surface.point_data["depth_um"]))
            assert upward * surface.points[deepest, 2] <= -0.99 * scar.max_depth_um
    assert not list((tmp_path / "vtk").glob(".*"))


@pytest.mark.parametrize("angle", [0.0, 30.0, 60.0, 90.0, 180.0, -90.0])
def test_sampling_turns_the_wire_into_the_sliding_frame(angle: float) -> None:
    """A plane of depths, tilted along and across the wire, is tilted along the turned directions."""
    axial, transverse = np.linspace(-50.0, 50.0, 11), np.linspace(-50.0, 50.0, 11)
    depth = 300.0 + axial[:, None] + 3.0 * transverse[None, :]
    zero = np.zeros_like(depth)
    scar = Scar(1, "fixed", 0.45, angle, axial, transverse, depth, zero, zero, zero)
    x, y = np.array([-20.0, 0.0, 10.0]), np.array([-7.0, 25.0])
    a = math.radians(angle)
    along = x[:, None] * math.cos(a) + y[None, :] * math.sin(a)
    across = y[None, :] * math.cos(a) - x[:, None] * math.sin(a)
    np.testing.assert_allclose(scar.sampled(x, y), 300.0 + along + 3.0 * across, rtol=1e-12)


@pytest.mark.parametrize(("angle", "half_um"), [(0.0, 80.0), (90.0, 30.0)])
def test_section_along_motion_crosses_the_scar_at_its_middle(angle: float, half_um: float) -> None:
    """Along the motion it is the axial section, across it the transverse one: depth·(1 − (x/half)²)."""
    scar = bowl("fixed", depth_um=9.0, half_length_um=80.0, half_width_um=30.0, axis_angle_deg=angle)
    x, depth = scar.section_along_motion()
    np.testing.assert_allclose(depth, 9.0 * np.maximum(1.0 - (x / half_um) ** 2, 0.0), atol=1e-9)
    assert x[0] == pytest.approx(-1.5 * half_um)
    assert x[-1] == pytest.approx(1.5 * half_um)


def test_section_of_a_skew_wire_agrees_with_its_samples() -> None:
    """At 60° the section lies on sampled(x, 0) and stays within the grid."""
    scar = bowl("fixed", 9.0, 80.0, 30.0, axis_angle_deg=60.0)
    x, depth = scar.section_along_motion()
    np.testing.assert_allclose(depth, scar.sampled(x, np.array([0.0]))[:, 0], atol=1e-12)
    assert np.all(np.diff(x) > 0.0)
    assert abs(x).max() == pytest.approx(1.5 * 30.0 / math.sin(math.radians(60.0)))


def test_an_evolution_has_all_columns_equally_long_and_increasing_cycles() -> None:
    """Missing, unequal or unordered columns are refused."""
    columns = dict(result().evolution)
    with pytest.raises(ResultError, match=r"column\(s\) missing: cycle"):
        Evolution({name: column for name, column in columns.items() if name != "cycle"})
    with pytest.raises(ResultError, match="equally long"):
        Evolution({**columns, "jump_cycles": np.zeros(2)})
    with pytest.raises(ResultError, match="cycle must increase"):
        Evolution({**columns, "cycle": columns["cycle"][::-1]})


in_one_folder = settings(
    deadline=None, max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
)
finite = st.floats(allow_nan=False, allow_infinity=False, width=64)
texts = st.text(max_size=12)
numbers = st.dictionaries(texts, finite, max_size=3)
json_values: st.SearchStrategy[Any] = st.recursive(
    st.none() | st.booleans() | finite | texts,
    lambda v: st.lists(v, max_size=2) | st.dictionaries(texts, v, max_size=2),
    max_leaves=6,
)


def arrays(shape: int | tuple[int, ...], elements: st.SearchStrategy[float] = finite) -> st.SearchStrategy[Any]:
    return hnp.arrays(np.float64, shape, elements=elements)


@st.composite
def loops(draw: st.DrawFn) -> Loop:
    n = draw(st.integers(1, 5))
    return Loop(draw(st.integers(1, 10**6)), *(draw(arrays(n)) for _ in range(6)))


@st.composite
def scars(draw: st.DrawFn) -> Scar:
    n_a, n_t = draw(st.integers(2, 4)), draw(st.integers(2, 4))
    lines = [np.sort(draw(hnp.arrays(np.float64, n, elements=finite, unique=True))) for n in (n_a, n_t)]
    depth = draw(arrays((n_a, n_t), st.floats(0.0, 1e3)))
    angle, diameter = draw(st.floats(-180.0, 180.0)), draw(st.floats(0.01, 10.0))
    wire = draw(st.sampled_from(["moving", "fixed"]))
    fields = (depth, *(draw(arrays((n_a, n_t))) for _ in range(3)))
    return Scar(draw(st.integers(1, 10**6)), wire, diameter, angle, lines[0], lines[1], *fields)


@st.composite
def plastic_strains(draw: st.DrawFn) -> PlasticStrain:
    shape = tuple(draw(st.integers(2, 3)) for _ in range(3))
    along, across, depths = (draw(arrays(n)) for n in (*shape[1:], shape[0]))
    return PlasticStrain(draw(st.sampled_from(["moving", "fixed"])), along, across, depths, draw(arrays((*shape, 6))))


@st.composite
def results(draw: st.DrawFn) -> RunResult:
    n = draw(st.integers(0, 3))
    nan_or_finite = st.floats(allow_infinity=False)
    columns = {name: draw(arrays(n, nan_or_finite)) for name in (*EVOLUTION_COLUMNS, "further_mm")}
    return RunResult(
        name=draw(texts), variant=draw(texts), fidelity=draw(texts),
        status=draw(st.sampled_from(["complete", "running", "failed"])), message=draw(texts),
        study=draw(st.dictionaries(texts, json_values, max_size=3)), loops=tuple(draw(st.lists(loops(), max_size=3))),
        evolution=Evolution({**columns, "cycle": np.arange(1.0, n + 1.0)}),
        scars=tuple(draw(st.lists(scars(), max_size=3))),
        settings=draw(st.dictionaries(texts, json_values, max_size=3)), quality=draw(numbers),
        versions=draw(st.dictionaries(texts, texts, max_size=2)), timings_s=draw(numbers),
        plastic_strain=tuple(draw(st.lists(plastic_strains(), max_size=2))),
    )  # fmt: skip


def assert_same(one: object, other: object) -> None:
    """Equal to the last bit, field by field; the path read from is no part of a result's value."""
    assert type(one) is type(other)
    if isinstance(one, np.ndarray):
        np.testing.assert_array_equal(one, other)
    elif isinstance(one, tuple) and isinstance(other, tuple):
        assert len(one) == len(other)
        for a, b in zip(one, other, strict=True):
            assert_same(a, b)
    elif isinstance(one, Evolution) and isinstance(other, Evolution):
        assert set(one) == set(other)
        for name in one:
            assert_same(one[name], other[name])
    elif dataclasses.is_dataclass(one):
        for field in dataclasses.fields(one):
            if field.name != "path":
                assert_same(getattr(one, field.name), getattr(other, field.name))
    else:
        assert one == other


@pytest.mark.seconds
@in_one_folder
@given(run=results())
def test_what_is_written_is_read_back_to_the_last_bit(run: RunResult, tmp_path: Path) -> None:
    """Any valid result survives the file, whatever its texts and numbers."""
    path = tmp_path / "result.h5"
    write_result(path, run)
    read = read_result(path)
    assert_same(run, read)
    assert read.path == path
    assert [p.name for p in tmp_path.iterdir()] == ["result.h5"]


@in_one_folder
@given(share=st.floats(0.0, 1.0, exclude_max=True))
def test_a_file_cut_short_is_refused(share: float, tmp_path: Path) -> None:
    """Wherever it ends."""
    path = tmp_path / "r.h5"
    if not path.exists():
        write_result(path, result(milestones=(1, 10), samples=8))
    whole = path.read_bytes()
    (tmp_path / "cut.h5").write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(
        ResultError, match=r"cut\.h5 is (no wirewear result file|cut off: [\d\u2009]+ of|damaged: its checksum)"
    ):
        read_result(tmp_path / "cut.h5")


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda f: f.attrs.__setitem__("kind", "other"), "is no wirewear result file"),
        (lambda f: f.attrs.__setitem__("format", 7), "has result format 7; this program reads format 3"),
        (lambda f: f.__delitem__("evolution/cycle"), r"is damaged: evolution: column\(s\) missing: cycle"),
        (lambda f: f.__delitem__("scars/0000/depth_um"), "is damaged: .*depth_um"),
        (lambda f: f.__delitem__("study"), "is damaged: .*study"),
        (
            lambda f: f["loops/0001/time_s"].__setitem__(3, np.nan),
            "is damaged: loop of cycle 100: time_s must be finite",
        ),
    ],
)
def test_a_file_with_wrong_contents_is_refused_with_the_reason(change: Any, sentence: str, tmp_path: Path) -> None:
    """The sentence names the file and what is wrong in it."""
    path = tmp_path / "r.h5"
    write_result(path, result())
    with h5py.File(path, "r+") as file:
        change(file)
    path.write_bytes(sealed(path.read_bytes()))
    with pytest.raises(ResultError, match=f"r.h5 {sentence}"):
        read_result(path)


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
    for one in (earlier, earlier.of_length(7.0)):
        table = evolution_table(one)
        for name, column in written.items():
            assert table[name].to_numpy() == pytest.approx(column, rel=1e-12), name
        assert loops_table(one)["tangential_force_N_per_mm"].max() == pytest.approx(60.0, rel=1e-3)
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
    one = read_result(tmp_path / "first.h5")
    assert all(np.isnan(loop.normal_force_N).all() and np.isnan(loop.tilt_deg).all() for loop in one.loops)
    assert np.isnan(one.evolution["normal_force_N"]).all()
    assert one.evolution["max_tangential_force_N"] == pytest.approx(60.0, rel=1e-3)


def test_columns_of_an_evolution_keep_their_order_in_a_file(earlier: RunResult, tmp_path: Path) -> None:
    """A run that goes on from its file writes the same tables as one that nothing stopped."""
    turned = Evolution({name: earlier.evolution[name] for name in reversed(list(earlier.evolution))})
    assert list(turned) != list(earlier.evolution)
    write_result(tmp_path / "result.h5", replace(earlier, evolution=turned))
    assert list(read_result(tmp_path / "result.h5").evolution) == list(turned)
