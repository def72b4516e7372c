"""Every mistake in a study gets one sentence: what is wrong, where, and what would be right."""

import pytest

from tests.studies import MINIMAL
from wirewear import StudyError
from wirewear.study import parse_study

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
youngs_modulus_MPa = 210000 => youngs_modulus_MPa = 210
    youngs_modulus_MPa in [wires] of s.toml is 210, but must lie between 1000 and 1500000 megapascals: it looks like
    gigapascals, which would be 210000 here.
normal_load_N = 2.0 => normal_load_N = -2.0
    normal_load_N in [conditions] of s.toml is -2.0, but must lie between 0.001 and 10000 newtons.
friction = 0.62 => friction = -0.62
    friction in [contact] of s.toml is -0.62, but must lie between 0 and 2.
friction = 0.62 => friction = nan
    friction in [contact] of s.toml is nan, but must be a finite number between 0 and 2.
friction = 0.62 => friction = "0.62"
    friction in [contact] of s.toml is the text '0.62', but must be a number between 0 and 2: write it without quotes,
    0.62.
friction = 0.62 => friction = true
    friction in [contact] of s.toml is True, but must be a number between 0 and 2.
friction = 0.62 =>
    missing key 'friction' in [contact] of s.toml: give the coefficient of friction, for example friction = 0.62.
frequency_Hz = 3.0 =>
    missing key 'frequency_Hz' in [conditions] of s.toml: give the cycles per second, in hertz, for example frequency_Hz
    = 3.0.
[contact]\nfriction = 0.62 =>
    missing table [contact] in s.toml: it must give friction.
friction = => frction =
    unknown key 'frction' in [contact] of s.toml: did you mean 'friction'?
[contact] => [contcat]
    unknown key 'contcat' in s.toml: did you mean 'contact'?
[contact] => moving_share = 0.5\n[contact]
    unknown key 'moving_share' in [conditions] of s.toml: it belongs in [wear].
friction = 0.62 => friction = 0.62\ncolour = 1
    unknown key 'colour' in [contact] of s.toml: the keys known there are friction, friction_law, formulation,
    primary_wire.
cycles = 700 => cycles = 7.5
    cycles in [conditions] of s.toml is 7.5, but must be a whole number between 1 and 1000000000 cycles.
displacement_amplitude_um = 60.0 => stroke_um = 120
    unknown key 'stroke_um' in [conditions] of s.toml: give displacement_amplitude_um, the imposed displacement
    amplitude, half the stroke.
friction = 0.62 => frction = 0.62\ncolour = 1
    unknown key 'frction' in [contact] of s.toml: did you mean 'friction'? Unknown key 'colour' in [contact] of s.toml:
    the keys known there are friction, friction_law, formulation, primary_wire.
friction = 0.62 => friction = 0,62
    s.toml is not valid TOML: expected newline or end of document after a statement (at line 15, column 13); the decimal
    sign is a point: friction = 0.62.
friction = 0.62 => friction = "0,62"
    friction in [contact] of s.toml is the text '0,62', but must be a number between 0 and 2: write it without quotes,
    0.62.
normal_load_N = 2.0 => normal_load_N = 2.0 N
    s.toml is not valid TOML: expected newline or end of document after a statement (at line 10, column 21); the unit
    stands in the key's name: normal_load_N = 2.0.
kind = "crossed-wires" => kind = crossed-wires
    s.toml is not valid TOML: invalid value (at line 4, column 8); a text stands in quotes: kind = "crossed-wires".
poissons_ratio = 0.3 => poissons_ratio = 0.5
    poissons_ratio in [wires] of s.toml is 0.5, but must lie between 0 and 0.49.
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
[contact] => [variants.a.holdr]\n[contact]
    unknown key 'holdr' in [variants.a] of s.toml: did you mean 'holder'?
[contact] => [variants.a]\nfriction = 1\n[contact]
    'friction' in [variants.a] of s.toml is 1, but a variant holds only tables such as [variants.a.holder].
[contact] => [variants."../a".holder]\n[contact]
    the variant '../a' in s.toml needs another name: letters, digits, _ and - only, 64 at most.
[contact] => [variants]\na = 3\n[contact]
    variants.a in s.toml is 3, but must be a table like [variants.a.holder].
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
format = 1 => wear = 3\nformat = 1
    wear in s.toml is 3, but must be a table.
format = 1 => format =
    s.toml is not valid TOML: invalid value (at line 2, column 9).
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
def test_a_mistake_is_told_in_one_sentence_with_its_place_and_what_would_be_right(
    old: str, new: str, message: str
) -> None:
    assert MINIMAL.count(old) == 1
    with pytest.raises(StudyError) as caught:
        parse_study(MINIMAL.replace(old, new), "s.toml")
    assert str(caught.value) == message
