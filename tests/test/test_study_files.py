"""Files, values and names of materials where a study is wanted: a study, or one sentence."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from tests.studies import MINIMAL, WEARING, minimal
from wirewear import StudyError
from wirewear.app.cli import cli
from wirewear.kinds import load_any_study
from wirewear.simulation import discretise
from wirewear.test import Study, parse_study, study_from_tables
from wirewear.test.bodies import Wire
from wirewear.test.consistency import default_loop_cycles
from wirewear.test.keys import Table, quantity_of, table_of
from wirewear.test.materials import material_named, materials, rubbing_pairs
from wirewear.test.tables import StudyTables

scalars = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20) | st.dates()
junk = st.recursive(scalars, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3))
paths = st.sampled_from(
    [(table,) for table in [*StudyTables.model_fields, "variants"]]
    + [(table, key) for table, value in minimal().items() if isinstance(value, dict) for key in value]
    + [("log", "loop_cycles"), ("variants", "a"), ("variants", "a", "wires"), ("fidelity", "quick"), ("wires", "fixed")]
)


def test_a_minimal_study_has_no_wear_a_rigid_holder_and_loops_by_decades() -> None:
    study = parse_study(MINIMAL, "study.toml")
    assert study.wear is None
    assert study.holder.tangential_stiffness_N_per_mm == "rigid"
    assert study.holder.normal_spring_stiffness_N_per_mm == 0.0
    assert study.wires.crossing_angle_deg == 90.0
    assert study.variant_names == ()
    assert study.fidelity("quick").contact_mesh_um is None
    assert parse_study(MINIMAL, "study.toml").log.loop_cycles == (1, 2, 5, 10, 20, 50, 100, 200, 500, 700)
    assert default_loop_cycles(1) == (1,)
    assert default_loop_cycles(1000) == (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)


def test_a_wire_of_its_own_overrides_the_common_one_key_by_key() -> None:
    study = parse_study(MINIMAL + "[wires.fixed]\ndiameter_mm = 1.0\nlength_mm = 3\n", "study.toml")
    moving, fixed = study.bodies
    assert isinstance(moving, Wire)
    assert isinstance(fixed, Wire)
    assert (fixed.diameter_mm, fixed.length_mm, fixed.youngs_modulus_MPa) == (1.0, 3.0, 210_000.0)
    assert (moving.diameter_mm, moving.length_mm) == (0.45, None)


def test_a_variant_changes_its_own_keys_and_keeps_the_others() -> None:
    text = MINIMAL + (
        "[holder]\ntangential_stiffness_N_per_mm = 167\nnormal_spring_stiffness_N_per_mm = 1\n"
        '[variants.stiff.holder]\ntangential_stiffness_N_per_mm = "rigid"\n'
        "[variants.short.conditions]\ncycles = 10\n"
    )
    study = parse_study(text, "study.toml")
    stiff, short = study.variant("stiff"), study.variant("short")
    assert study.variant_names == ("stiff", "short")
    assert (stiff.variant_name, stiff.variant_names) == ("stiff", ())
    assert stiff.holder.tangential_stiffness_N_per_mm == "rigid"
    assert stiff.holder.normal_spring_stiffness_N_per_mm == 1.0
    assert short.holder.tangential_stiffness_N_per_mm == 167.0
    assert (short.conditions.cycles, short.log.loop_cycles) == (10, (1, 2, 5, 10))


def test_every_number_that_a_study_may_hold_has_a_description_and_a_unit_in_its_name() -> None:
    plain = {"poissons_ratio", "friction", "moving_share", "cycles", "jump_tolerance", "wear_factor"}
    # Relative scatter of what is named.
    plain |= {"normal_load", "wear", "tangential_stiffness"}
    # Of fatigue.
    plain |= {"fatigue_strength_exponent", "fatigue_ductility_coefficient", "fatigue_ductility_exponent"}
    plain |= {"fatemi_socie_factor", "crossland_slope", "scatter_decades"}
    plain |= {"increments_per_cycle", "increments_per_wear_cycle", "mesh_refinement", "contact_states"}

    def check(table: type[Table]) -> int:
        count = 0
        for name, field in table.model_fields.items():
            assert field.description, name
            quantity, inner = quantity_of(field), table_of(field)
            if quantity is not None:
                count += 1
                assert name in plain or name.endswith(f"_{quantity.unit}"), name
            elif inner is not None:
                count += check(inner)
        return count

    assert check(StudyTables) > 30


@pytest.mark.seconds
@given(
    diameter=st.floats(0.1, 20.0),
    load=st.floats(1e-3, 1e4),
    friction=st.floats(0.0, 2.0),
    stiffness=st.floats(1.0, 1e7) | st.just("rigid"),
    wear=st.none() | st.floats(0.0, 1e-2),
    cycles=st.integers(1, 10**9),
    variant_load=st.none() | st.floats(1e-3, 1e4),
)
def test_the_resolved_tables_read_back_give_the_same_study(
    diameter: float,
    load: float,
    friction: float,
    stiffness: float | str,
    wear: float | None,
    cycles: int,
    variant_load: float | None,
) -> None:
    data = minimal()
    data["wires"]["diameter_mm"] = diameter
    data["conditions"] |= {"normal_load_N": load, "cycles": cycles}
    data["contact"]["friction"] = friction
    data["holder"] = {"tangential_stiffness_N_per_mm": stiffness}
    if wear is not None:
        data["wear"] = {"energy_wear_coefficient_mm3_per_J": wear}
    if variant_load is not None:
        data["variants"] = {"other": {"conditions": {"normal_load_N": variant_load}}}
    study = study_from_tables(data, "study.toml")
    assert study.conditions.normal_load_N == load
    assert study_from_tables(json.loads(json.dumps(study.resolved())), "resolved") == study


@pytest.mark.parametrize(
    ("holder", "sentence"),
    [
        ("rotational_stiffness_N_mm_per_rad = 13500", "pivot_height_mm"),
        ("normal_spring_stiffness_N_per_mm = 1", "approach_um"),
    ],
)
def test_a_holder_whose_keys_contradict_each_other_is_refused(holder: str, sentence: str) -> None:
    text = MINIMAL.replace("[conditions]", "[conditions]\napproach_um = 0.9")
    with pytest.raises(StudyError, match=sentence):
        parse_study(f"{text}\n[holder]\n{holder}\n", "s.toml")


def test_a_shorter_test_records_the_asked_cycles_it_reaches_from_file_and_python() -> None:
    text = MINIMAL + "[log]\nloop_cycles = [1, 3, 500, 700]\n"
    short = parse_study(text.replace("cycles = 700", "cycles = 10"), "study.toml")
    assert short.log.loop_cycles == (1, 3, 10)
    assert parse_study(text, "study.toml").with_values({"conditions.cycles": 10}).tables == short.tables
    variant = parse_study(text + "[variants.short.conditions]\ncycles = 10\n", "study.toml").variant("short")
    assert variant.log.loop_cycles == (1, 3, 10)


@pytest.mark.seconds
@given(paths, junk)
def test_any_value_in_any_place_is_accepted_or_refused_in_one_sentence(keys: tuple[str, ...], value: object) -> None:
    data = minimal()
    here = data
    for key in keys[:-1]:
        here = here.setdefault(key, {})
    here[keys[-1]] = value
    try:
        study = study_from_tables(data, "s.toml")
    except StudyError as error:
        sentence = str(error)
        assert "s.toml" in sentence
        assert sentence[-1] in ".?"
        assert "\n" not in sentence
    else:
        assert isinstance(study, Study)


ROOT = Path(__file__).parents[2]
NAMED = re.sub(r"youngs_modulus.*\npoissons_ratio.*\n", 'material = "Ti6Al4V"\n', MINIMAL)


def import_wirewear(first_on_path: Path, before: str = "") -> subprocess.CompletedProcess[str]:
    code = f"import sys; sys.path[:0] = [{str(first_on_path)!r}, {str(ROOT)!r}]\n{before}\nimport wirewear"
    return subprocess.run([sys.executable, "-c", code], cwd=first_on_path, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("name", ["geometry", "solvers"])
@pytest.mark.parametrize("form", ["{name}.py", "{name}/__init__.py"])
def test_a_shadowing_module_is_named_with_what_to_do(tmp_path: Path, name: str, form: str) -> None:
    stranger = tmp_path / form.format(name=name)
    stranger.parent.mkdir(exist_ok=True)
    stranger.write_text("", encoding="utf-8")
    run = import_wirewear(tmp_path)
    last_line = run.stderr.strip().splitlines()[-1]
    assert run.returncode != 0
    assert last_line.startswith(f"ImportError: wirewear needs its own package '{name}'")
    assert str(stranger) in last_line
    assert "rename or remove" in last_line


@pytest.mark.seconds
def test_everything_offered_is_there_and_nothing_is_loaded_before_it_is_asked_for() -> None:
    code = (
        "import sys, wirewear\n"
        "assert not {'numpy', 'h5py', 'wirewear.test'} & set(sys.modules)\n"
        "assert all(getattr(wirewear, name) is not None for name in wirewear.__all__)\n"
        "assert set(wirewear.__all__) <= set(dir(wirewear))\n"
        "assert not hasattr(wirewear, 'gremlins')\n"
    )
    run = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")


def test_every_material_has_a_source_and_constants_of_a_solid() -> None:
    for item in materials():
        assert [material_named(name) for name in (item.name, *item.also)] == [item] * (1 + len(item.also))
        assert len(item.source) > 10
        assert 3e3 < item.elastic.youngs_modulus_MPa < 7e5
        assert 0.2 < item.elastic.poissons_ratio <= 0.4


def test_hardness_is_about_three_times_the_stress_at_a_strain_of_eight_per_cent() -> None:
    """Tabor, The Hardness of Metals (1951)."""
    hard = [(dict(item.yields), item.hardness_HV) for item in materials() if item.hardness_HV is not None]
    assert len(hard) >= 7
    for yields, hardness_HV in hard:
        stress = yields["yield_stress_MPa"] + 0.08 * yields["hardening_modulus_MPa"]
        assert 0.8 < 9.807 * hardness_HV / 3.0 / stress < 1.6


def test_every_friction_and_wear_coefficient_of_the_literature_has_a_dated_source() -> None:
    pairs = rubbing_pairs()
    assert sum(bool(pair.energy_wear_coefficient_mm3_per_J) for pair in pairs) >= 6
    for pair in pairs:
        assert re.search(r"\((19|20)\d\d\)", pair.source)
        assert pair.friction or pair.energy_wear_coefficient_mm3_per_J
        assert all(0.05 < value < 1.5 for value in pair.friction)
        assert all(1e-9 < value < 1e-2 for value in pair.energy_wear_coefficient_mm3_per_J)
    listed = CliRunner().invoke(cli, ["materials"]).output
    assert "4.4e-05" in listed
    assert "alumina ball" in listed


@pytest.mark.parametrize(
    "names",
    [
        ("AISI 52100", "52100", "100Cr6", "suj2", "EN 31"),
        ("304", "AISI-304"),
        ("Inconel718", "inconel-718", "Alloy 718"),
        ("Ti-6Al-4V", "Ti6Al4V", "TA6V", "TiAl6V4"),
        ("PEEK", "peek"),
    ],
)
def test_what_laboratories_rub_is_found_by_every_name_that_it_goes_by(names: tuple[str, ...]) -> None:
    assert len({material_named(name) for name in names}) == 1


def test_a_material_has_any_of_its_names_and_unread_sources_are_listed() -> None:
    listed = CliRunner().invoke(cli, ["materials"]).output
    verified = [*(item.verified for item in materials()), *(pair.verified for pair in rubbing_pairs())]
    assert listed.count("unverified:") == verified.count(False) > 0
    study, titanium = parse_study(NAMED, "study.toml"), material_named("Ti-6Al-4V").elastic
    assert [body.material for body in study.bodies] == [titanium, titanium]
    assert study.wires.material == "Ti-6Al-4V"
    assert study_from_tables(study.resolved(), "again").resolved() == study.resolved()


def test_a_body_yields_where_its_material_is_named_by_condition_unless_it_or_another_material_says_otherwise() -> None:
    named = NAMED.replace("Ti6Al4V", "rope wire 1960")
    own = named.replace("[conditions]", "yield_stress_MPa = 1800.0\n[conditions]")
    other = named.replace("[conditions]", 'moving.material = "alumina"\n[conditions]')
    for text, expected in (
        (NAMED, (None, None)),
        (named, ((1570.0, 800.0), (1570.0, 800.0))),
        (own, ((1800.0, 0.0), (1800.0, 0.0))),
        (other, (None, (1570.0, 800.0))),
    ):
        study = parse_study(text, "study.toml")
        assert tuple(study.tables.yields.values()) == expected
        assert study_from_tables(study.resolved(), "again").bodies == study.bodies


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (NAMED.replace("Ti6Al4V", "brass"), r"material in \[wires\] of study.toml is 'brass', which is in no table"),
        (NAMED.replace("Ti6Al4V", "Ti-6Al-4W"), r"did you mean 'Ti-6Al-4V'.*\?$"),
        (NAMED.replace("Ti6Al4V", "Inconel 609"), r"did you mean 'Inconel 690' or 'Inconel 600' or 'Inconel 718'\?$"),
        (NAMED.replace("material", "poissons_ratio = 0.2\nmaterial"), r"poissons_ratio = 0.2 beside the material"),
        (MINIMAL + "[variants.a.wires]\nmaterial = 'alumina'\n", r"beside the material 'alumina', which has 416000"),
    ],
)
def test_an_unknown_material_and_one_beside_other_constants_are_refused(text: str, complaint: str) -> None:
    with pytest.raises(StudyError, match=complaint):
        parse_study(text, "study.toml")


TUBE = """format = 1
name = "tube on bar"
kind = "point-contact"
[bodies.lower]
shape = "cylinder"
diameter_mm = 6.0
material = "steel"
[bodies.upper]
shape = "tube"
diameter_mm = 8.0
bore_mm = 5.0
axis_angle_deg = 90
material = "steel"
[conditions]
normal_load_N = 10.0
displacement_amplitude_um = 20.0
frequency_Hz = 5.0
cycles = 100
[contact]
friction = 0.5
"""
PIVOT = "[holder]\npivot_height_mm = 10\n"
TURNS = "rotational_stiffness_N_mm_per_rad = 1e5\n"
PULLED = "[wires.fixed.bulk]\naxial_stress_MPa = 40\nphase_deg = 90\n"


@pytest.mark.parametrize(
    ("idle", "acts", "key"),
    [
        (MINIMAL + PIVOT, MINIMAL + PIVOT + TURNS, "pivot_height_mm in [holder]"),
        (
            MINIMAL + PIVOT + "[variants.a.conditions]\ncycles = 10\n",
            MINIMAL + PIVOT + "[variants.a.conditions]\ncycles = 10\n[variants.b.holder]\n" + TURNS,
            "pivot_height_mm in [holder]",
        ),
        (MINIMAL + PULLED, MINIMAL + PULLED + "axial_stress_amplitude_MPa = 5\n", "phase_deg in [wires.fixed.bulk]"),
        (
            TUBE.replace("6.0\n", "6.0\ngrip_angle_deg = 40\n"),
            TUBE.replace("bore_mm", "grip_angle_deg = 40\nbore_mm"),
            "grip_angle_deg in [bodies.lower]",
        ),
        (
            TUBE.replace("bore_mm", 'grip_angle_deg = 40\nheld_at = "ends"\nbore_mm'),
            TUBE.replace("bore_mm", 'held_at = "ends"\nbore_mm'),
            "grip_angle_deg in [bodies.upper]",
        ),
        (
            TUBE.replace("bore_mm", "height_mm = 4\nbore_mm"),
            TUBE.replace("6.0\n", "6.0\nheight_mm = 4\n"),
            "height_mm in [bodies.upper]",
        ),
        (
            MINIMAL + "[mesh]\nmove_nodes_at_stages = true\nmove_nodes_every_um = 1.0\n",
            MINIMAL + "[mesh]\nmove_nodes_at_stages = true\n",
            "move_nodes_at_stages in [mesh]",
        ),
        (
            MINIMAL + "[stop]\naccumulated_energy_J = 3\n",
            MINIMAL + WEARING + "[stop]\naccumulated_energy_J = 3\n",
            "accumulated_energy_J in [stop]",
        ),
        (
            MINIMAL + "[life]\naveraging_length_um = 20\ncritical_distance_um = 10\n",
            MINIMAL + "[life]\ncritical_distance_um = 10\n",
            "critical_distance_um in [life]",
        ),
    ],
)
def test_a_key_that_acts_in_no_run_is_refused_and_one_that_acts_in_some_is_not(
    tmp_path: Path, idle: str, acts: str, key: str
) -> None:
    path = tmp_path / "study.toml"
    path.write_text(acts)
    assert load_any_study(path)
    path.write_text(idle)
    with pytest.raises(StudyError, match=re.escape(key)) as message:
        load_any_study(path)
    assert str(message.value).count(". ") == 0
    assert load_any_study(path, varied=True)


def test_what_belongs_to_heights_is_refused_beside_a_file_of_depths(tmp_path: Path) -> None:
    (tmp_path / "scar.csv").write_text("x_um,y_um,depth_um\n0,0,0\n0,1,1\n1,0,1\n1,1,0\n")
    path = tmp_path / "study.toml"
    path.write_text(MINIMAL + '[wires.fixed.surface]\nfile = "scar.csv"\ncentred_on = "map"\n')
    with pytest.raises(StudyError, match="centred_on, which is of heights"):
        load_any_study(path)


def test_a_key_of_another_table_is_written_with_its_table_in_a_block() -> None:
    block = "[[programme]]\ncycles = 5\ndisplacement_amplitude_um = 20\n"
    with pytest.raises(StudyError, match=r"number 1 of s: write conditions\.displacement_amplitude_um\.$"):
        parse_study(MINIMAL + block, "s")
    parse_study(MINIMAL + block.replace("displacement", "conditions.displacement"), "s")


@pytest.mark.parametrize("refinement", [0.5, 2.0])
def test_a_refinement_makes_stated_elements_finer_as_well(refinement: float) -> None:
    text = MINIMAL + "[fidelity.quick]\ncontact_mesh_um = 8\nouter_mesh_um = 12\n"
    coarse, fine = (
        discretise(parse_study(one, "study.toml"), "quick").settings()
        for one in (text, text + f"mesh_refinement = {refinement}\n")
    )
    for key in ("contact_mesh_um", "outer_mesh_um"):
        assert fine[key] == pytest.approx(coarse[key] / refinement)
