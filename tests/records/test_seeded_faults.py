"""Faults put into a sound record one by one: `check` names each kind, and nothing is concluded without a word of it."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geometry.arrays import Array
from wirewear import RecordError, check_record, read_record, write_record
from wirewear.records import ExperimentRecord, MeasuredEvolution, MeasuredLoop, MeasuredScar, checking
from wirewear.records.checking import problems_of
from wirewear.records.importing.loop_sources import read_loops

pytestmark = pytest.mark.seconds
EXAMPLE = Path(__file__).parents[2] / "studies" / "steel_wires" / "example_records" / "no_gap"
Change = Callable[[ExperimentRecord], ExperimentRecord]


@pytest.fixture(scope="module")
def sound() -> ExperimentRecord:
    return read_record(EXAMPLE)


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """All loops are checked by their statistics; few need be analysed in full."""
    monkeypatch.setattr(checking, "MOST_ANALYSED", 2)


def loops(changed: Callable[[MeasuredLoop], MeasuredLoop]) -> Change:
    return lambda record: replace(record, loops=tuple(changed(loop) for loop in record.loops))


def channel(name: str, changed: Callable[[Array], Array]) -> Change:
    def of_loop(loop: MeasuredLoop) -> MeasuredLoop:
        values: dict[str, Any] = {name: changed(getattr(loop, name))}
        return replace(loop, **values)

    return loops(of_loop)


def exchanged(one: str, other: str) -> Change:
    return loops(lambda loop: replace(loop, **{one: getattr(loop, other), other: getattr(loop, one)}))


def scars(changed: Callable[[MeasuredScar], MeasuredScar], *wires: str) -> Change:
    return lambda record: replace(
        record, scars=tuple(changed(scar) if scar.body in wires else scar for scar in record.scars)
    )


def evolution(changed: Callable[[dict[str, Array]], dict[str, Array]]) -> Change:
    return lambda record: replace(
        record,
        evolution=tuple(MeasuredEvolution(part.repeat, changed(dict(part.columns))) for part in record.evolution),
    )


def turned(scar: MeasuredScar) -> MeasuredScar:
    return replace(scar, x_um=scar.y_um, y_um=scar.x_um, depth_um=scar.depth_um.T)


def other_wire(record: ExperimentRecord) -> ExperimentRecord:
    other = {"moving": "fixed", "fixed": "moving"}
    return replace(record, scars=tuple(replace(scar, body=other[scar.body]) for scar in record.scars))


def renumbered(new_cycles: Callable[[tuple[int, ...]], list[int]]) -> Change:
    def changed(record: ExperimentRecord) -> ExperimentRecord:
        new = dict(zip(record.cycles, new_cycles(record.cycles), strict=True))
        numbered = [replace(loop, cycle=new[loop.cycle]) for loop in record.loops]
        return replace(record, loops=tuple(sorted(numbered, key=lambda loop: (loop.repeat, loop.cycle))))

    return changed


def repeated(record: ExperimentRecord) -> ExperimentRecord:
    first = [loop for loop in record.loops if loop.repeat == record.repeats[0]]
    copies = [replace(loop, repeat=repeat) for repeat in record.repeats for loop in first]
    return replace(record, loops=tuple(copies))


def copied(record: ExperimentRecord) -> ExperimentRecord:
    """The evolution and scars of the first repeat in the place of all."""
    part, repeat = record.evolution[0], record.repeats[0]
    return replace(
        record,
        evolution=tuple(MeasuredEvolution(one.repeat, part.columns) for one in record.evolution),
        scars=tuple(
            replace(next(own for own in record.scars_of(scar.body) if own.repeat == repeat), repeat=scar.repeat)
            for scar in record.scars
        ),
    )


def loops_of_two(one: tuple[int, int], other: tuple[int, int]) -> Change:
    """Two loops, named by repeat and cycle, each under the other's name."""
    names = {one: other, other: one}

    def changed(record: ExperimentRecord) -> ExperimentRecord:
        pairs = ((loop, names.get((loop.repeat, loop.cycle), (loop.repeat, loop.cycle))) for loop in record.loops)
        named = [replace(loop, repeat=repeat, cycle=cycle) for loop, (repeat, cycle) in pairs]
        return replace(record, loops=tuple(sorted(named, key=lambda loop: (loop.repeat, loop.cycle))))

    return changed


def mirrored(scar: MeasuredScar) -> MeasuredScar:
    return replace(scar, y_um=-scar.y_um[::-1], depth_um=scar.depth_um[:, ::-1])


def shuffled(values: Array) -> Array:
    """In no order, always the same."""
    return np.random.default_rng(5).permutation(values)


def halves_exchanged(values: Array) -> Array:
    """The third quarter of the samples before the second."""
    quarter = values.size // 4
    return np.concatenate([values[:quarter], values[2 * quarter : 3 * quarter], values[quarter : 2 * quarter],
                           values[3 * quarter :]])  # fmt: skip


def doubled(loop: MeasuredLoop) -> MeasuredLoop:
    """Every row twice, its samples numbered again."""
    return loop.taken(np.repeat(np.arange(loop.time_s.size), 2))


def rows(order: Callable[[Array], Array]) -> Change:
    return loops(lambda loop: loop.taken(order(np.arange(float(loop.time_s.size))).astype(int)))


def clipped(low: float, high: float) -> Callable[[Array], Array]:
    return lambda values: np.clip(values, low, high)


def scaled(factor: float) -> Callable[[Array], Array]:
    return lambda values: factor * values


FORCE, NORMAL, WAY = "tangential_force_N", "normal_force_N", "displacement_um"
#: Faults, what a problem says of each, and whether anything may be concluded nevertheless.
FAULTS: dict[str, tuple[Change, str, bool]] = {
    "normal force in mN": (channel(NORMAL, scaled(1e3)), "looks like millinewtons (unit = 'mN'", False),
    "normal force in gf": (channel(NORMAL, scaled(101.97)), "looks like gram-force (unit = 'gf'", False),
    "normal force in kgf": (channel(NORMAL, scaled(0.10197)), "looks like kilogram-force (unit = 'kgf'", False),
    "normal force in kN": (channel(NORMAL, scaled(1e-3)), "normal force is zero where 2 N were asked", False),
    "normal force in pounds": (channel(NORMAL, scaled(0.2248)), "looks like pounds", False),
    "load in kilograms": (channel(NORMAL, scaled(9.81)), "the load asked for is in kilograms", False),
    "normal force turned": (channel(NORMAL, scaled(-1.0)), "factor = -1 in a mapping", False),
    "normal force zero": (channel(NORMAL, scaled(0.0)), "leave the column out", False),
    "normal force exchanged": (exchanged(NORMAL, FORCE), "the two columns seem exchanged", False),
    "normal force and way exchanged": (exchanged(NORMAL, WAY), "normal force", False),
    "normal force clipped": (channel(NORMAL, clipped(0.0, 2.0)), "The normal force stays at its extreme", True),
    "force in mN": (channel(FORCE, scaled(1e3)), "check its unit", False),
    "force turned": (channel(FORCE, scaled(-1.0)), "drives the motion", False),
    "force zero": (channel(FORCE, scaled(0.0)), "check its unit", False),
    "force rectified": (channel(FORCE, np.abs), "rectified", False),
    "force clipped": (channel(FORCE, clipped(-0.9, 0.9)), "The tangential force stays at its extreme", False),
    "force clipped above": (channel(FORCE, clipped(-9.0, 0.9)), "The tangential force stays at its extreme", False),
    "force clipped below": (channel(FORCE, clipped(0.0, 9.0)), "The tangential force stays at its extreme", False),
    "force and way exchanged": (exchanged(FORCE, WAY), "displacement amplitude is", False),
    "way in mm": (channel(WAY, scaled(1e-3)), "it looks like millimetres", False),
    "way turned": (channel(WAY, scaled(-1.0)), "drives the motion", False),
    "way clipped": (channel(WAY, clipped(-50.0, 50.0)), "The displacement stays at its extreme", False),
    "way clipped above": (channel(WAY, clipped(-99.0, 50.0)), "The displacement stays at its extreme", False),
    "way shuffled": (channel(WAY, shuffled), "rows may be missing or re-ordered", False),
    "force shuffled": (channel(FORCE, shuffled), "rows may be missing or re-ordered", False),
    "rows shuffled": (rows(shuffled), "rows may be doubled or re-ordered", False),
    "blocks of values exchanged": (channel(WAY, halves_exchanged), "rows may be missing or re-ordered", False),
    "rows doubled": (loops(doubled), "rows may be doubled or re-ordered", False),
    "repeats copied": (repeated, "one is a copy", True),
    "other tables copied": (copied, "one is a copy", True),
    "cycles reversed": (renumbered(lambda cycles: list(cycles[::-1])), "in reverse order", True),
    "cycles exchanged": (renumbered(lambda c: [c[2], c[0], *c[3:], c[1]]), "in another order", True),
    "neighbouring cycles exchanged": (
        loops_of_two((2, 1000), (2, 10000)), "cycle 1000 of repeat 2 and cycle 10000 of repeat 2 have each other's",
        True,
    ),
    "two repeats at one cycle": (
        loops_of_two((1, 10000), (2, 10000)), "cycle 10000 of repeat 1 and cycle 10000 of repeat 2 have each other's",
        True,
    ),
    "evolution upside down": (
        evolution(lambda columns: {name: v if name == "cycle" else v[::-1] for name, v in columns.items()}),
        "with its rows in reverse order", True,
    ),
    "cycles in tens": (renumbered(lambda cycles: [10 * cycle for cycle in cycles]), "beyond the test's end", True),
    "both scars turned": (scars(turned, "moving", "fixed"), "are x and y exchanged", True),
    "moving scar turned": (scars(turned, "moving"), "are x and y exchanged", True),
    "fixed scar turned": (scars(turned, "fixed"), "are x and y exchanged", True),
    "scars of the other wires": (other_wire, "a map of the other body", True),
    "scars twice as long": (
        scars(lambda scar: replace(scar, x_um=2.0 * scar.x_um), "moving", "fixed"), "of another scale", True
    ),
    "scar twice as large": (
        scars(lambda scar: replace(scar, x_um=2.0 * scar.x_um, y_um=2.0 * scar.y_um), "moving"), "of another scale",
        True,
    ),
    "depths in mm": (
        scars(lambda scar: replace(scar, depth_um=1e-3 * scar.depth_um), "moving", "fixed"), "in another unit", True
    ),
    "negative energies": (
        evolution(lambda columns: columns | {"dissipated_energy_mJ": -columns["dissipated_energy_mJ"]}),
        "is negative in the evolution", False,
    ),
    "negative forces": (
        evolution(lambda columns: columns | {"max_tangential_force_N": -columns["max_tangential_force_N"]}),
        "is negative in the evolution", False,
    ),
    "energies in µJ": (
        evolution(lambda columns: columns | {"dissipated_energy_mJ": 1e3 * columns["dissipated_energy_mJ"]}),
        "its stroke and largest force allow", True,
    ),
    "strokes in place of amplitudes": (
        evolution(lambda columns: columns | {"displacement_amplitude_um": 2 * columns["displacement_amplitude_um"]}),
        "it may be the whole stroke", True,
    ),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_check_names_a_fault_and_nothing_is_concluded_without_a_word(sound: ExperimentRecord, fault: str) -> None:
    change, words, concludes = FAULTS[fault]
    record = change(sound)
    texts = [problem.text for problem in check_record(record).problems]
    assert any(words in text for text in texts), texts
    assert not any("nan" in text.split() or "inf" in text.split() for text in texts)
    if concludes:
        assert any(words in text for text in problems_of(record))
    else:
        with pytest.raises(RecordError, match="nothing can be concluded"):
            problems_of(record)


@pytest.mark.first_case
@pytest.mark.parametrize("exchange", [((1, 50), (2, 50)), ((3, 40), (3, 50))], ids=["repeats", "cycles"])
def test_without_an_evolution_the_other_repeats_reveal_loops_that_are_exchanged(
    sound: ExperimentRecord, exchange: tuple[tuple[int, int], tuple[int, int]]
) -> None:
    """Three repeats of other friction, whose force falls by 2 % from loop to loop."""
    base, rng = sound.loops[0], np.random.default_rng(3)
    made = [
        replace(
            base,
            repeat=repeat,
            cycle=cycle,
            tangential_force_N=friction * 0.98 ** (cycle / 10) * base.tangential_force_N
            + 0.005 * rng.standard_normal(base.time_s.size),
        )
        for repeat, friction in enumerate((1.0, 1.04, 0.97), 1)
        for cycle in range(10, 90, 10)
    ]
    bare = replace(sound, loops=tuple(made), evolution=())
    texts = [[problem.text for problem in check_record(one).problems] for one in (bare, loops_of_two(*exchange)(bare))]
    assert [sum("have each other's energy" in text for text in own) for own in texts] == [0, 1]


@pytest.mark.parametrize(("looked_at", "words"), [(12, "1 of 12 logged loops."), (2, "1 of 2 logged loops looked at.")])
def test_loops_that_were_refused_or_not_looked_at_support_no_conclusion(
    sound: ExperimentRecord, monkeypatch: pytest.MonkeyPatch, looked_at: int, words: str
) -> None:
    monkeypatch.setattr(checking, "MOST_ANALYSED", looked_at)
    first, *others = sound.loops
    clipped_ones = (replace(one, tangential_force_N=np.clip(one.tangential_force_N, -0.9, 0.9)) for one in others)
    supported = " ".join(check_record(replace(sound, loops=(first, *clipped_ones))).supports)
    assert f"friction of {words}" in supported
    assert "How loops change" not in supported


def test_a_normal_force_turned_is_said_and_one_in_another_unit_refused(sound: ExperimentRecord, tmp_path: Path) -> None:
    read = read_record(write_record(tmp_path / "record", channel(NORMAL, scaled(-1.0))(sound)))
    for loop, own in zip(read.loops, sound.loops, strict=True):
        np.testing.assert_array_equal(loop.normal_force_N, own.normal_force_N)
    assert any("factor = -1" in remark.text for remark in check_record(read).remarks)
    folder = write_record(tmp_path / "record", channel(NORMAL, scaled(1e3))(sound))
    with pytest.raises(RecordError, match="looks like millinewtons"):
        read_loops(folder)


@pytest.mark.first_case
@pytest.mark.parametrize("angle_deg", [30.0, 60.0, 90.0])
def test_scars_that_worn_cylinders_leave_are_no_problem_at_any_angle(sound: ExperimentRecord, angle_deg: float) -> None:
    """Of cylinders that overlap by 30 µm: half of the overlap each, the moving wire's drawn out by ±50 µm."""
    sine, cosine = np.sin(np.radians(angle_deg)), np.cos(np.radians(angle_deg))
    x, y = np.linspace(-450.0, 450.0, 181), np.linspace(-150.0, 150.0, 61)
    at_x, at_y = np.meshgrid(x, y, indexing="ij")
    radius_um = 225.0

    def overlap(shift: float) -> Array:
        gap = (at_y**2 + ((at_x - shift) * sine - at_y * cosine) ** 2) / (2.0 * radius_um)
        return np.asarray(np.maximum(15.0 - 0.5 * gap, 0.0))

    still = overlap(0.0)
    drawn = np.max([overlap(shift) for shift in np.linspace(-50.0, 50.0, 41)], axis=0)
    made = tuple(MeasuredScar(1, wire, x, y, depth) for wire, depth in (("moving", drawn), ("fixed", still)))
    wires = sound.tables.wires.model_copy(update={"crossing_angle_deg": angle_deg})
    record = replace(sound, tables=sound.tables.model_copy(update={"wires": wires}), scars=made)
    assert not [problem.text for problem in check_record(record).problems if "exchanged" in problem.text]
    wrong = replace(record, scars=(turned(made[0]), made[1]))
    assert [problem.text for problem in check_record(wrong).problems if "exchanged" in problem.text]
    assert not [problem.text for problem in check_record(record).problems if "mirrored" in problem.text]
    for place in (0, 1):
        seen = replace(record, scars=tuple(mirrored(own) if n == place else own for n, own in enumerate(made)))
        texts = [problem.text for problem in check_record(seen).problems if "mirrored" in problem.text]
        # At 90° a scar is its own mirror image.
        assert len(texts) == (angle_deg < 90.0)
