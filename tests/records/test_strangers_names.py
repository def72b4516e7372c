"""Logs with names in many languages and encodings, words for missing samples, raw and tared twins of channels."""

from pathlib import Path

import numpy as np
import pytest

from tests.records.strangers_files import FORCE, TIME, X, energy_mJ
from wirewear.base.errors import RecordError
from wirewear.base.naming import encoding_of, recognised
from wirewear.loops.sensor import enclosed_area
from wirewear.records.importing import guessing
from wirewear.records.importing.guessed_files import looked_into
from wirewear.records.importing.guessed_scars import Touching
from wirewear.records.importing.loop_sources import SampledLoop, read_loops
from wirewear.views.loops_report import analyse_loops, remarks

NO_WIRES = Touching.of("crossed-wires", {}, {}, {})

#: Names of time, displacement, force and load as loggers of a country write them, and encodings in which they do.
LANGUAGES = {
    "Japanese": ("時間[s],変位[μm],摩擦力[N],荷重[N]", ("cp932", "euc_jp", "utf-8-sig")),
    "Korean": ("시간(s),변위(㎛),마찰력(N),수직 하중(N)", ("cp949",)),
    "Taiwanese": ("時間(s),位移(um),摩擦力(N),正向力(N)", ("big5",)),
    "Russian": ("Время, с;Перемещение, мкм;Сила трения, Н;Нагрузка, Н", ("cp1251", "koi8_r", "cp866")),
    "Ukrainian": ("Час [с];Переміщення [мкм];Сила тертя [Н];Навантаження [Н]", ("cp1251",)),
    "Polish": ("Czas [s];Przemieszczenie [um];Siła tarcia [N];Obciążenie [N]", ("cp1250", "iso8859_2")),
    "Czech": ("Čas (s);Posunutí (um);Třecí síla (N);Zatížení (N)", ("cp1250",)),
    "Turkish": ("Zaman (s);Yer değiştirme (µm);Sürtünme kuvveti (N);Normal yük (N)", ("cp1254",)),
    "Greek": ("Χρόνος (s);Μετατόπιση (um);Δύναμη τριβής (N);Φορτίο (N)", ("cp1253",)),
    "Dutch": ("Tijd [s];Verplaatsing [µm];Wrijvingskracht [N];Normaalkracht [N]", ("cp1252",)),
    "Swedish": ("Tid (s);Förskjutning (µm);Friktionskraft (N);Normalkraft (N)", ("cp1252", "cp850")),
    "Finnish": ("Aika (s);Siirtymä (µm);Kitkavoima (N);Kuorma (N)", ("cp1252",)),
    "Hungarian": ("Idő (s);Elmozdulás (um);Súrlódási erő (N);Terhelés (N)", ("cp1250",)),
    "Romanian": ("Timp (s);Deplasare (um);Forță de frecare (N);Sarcină (N)", ("utf-8",)),
    "Serbian": ("Vreme (s);Pomeranje (um);Sila trenja (N);Normalna sila (N)", ("cp1250",)),
    "Catalan": ("Temps (s);Desplaçament (um);Força de fricció (N);Càrrega normal (N)", ("cp1252",)),
    "Estonian": ("Aeg (s);Nihe (um);Hõõrdejõud (N);Normaaljõud (N)", ("utf-8",)),
    "Lithuanian": ("Laikas (s);Poslinkis (um);Trinties jėga (N);Normalinė jėga (N)", ("utf-8",)),
    "Latvian": ("Laiks (s);Pārvietojums (um);Berzes spēks (N);Normālspēks (N)", ("utf-8",)),
    "Indonesian": ("Waktu (s);Perpindahan (um);Gaya gesek (N);Beban normal (N)", ("utf-8",)),
    "English": ("Time (s),Displacement (um),Force (N),Normal (N)", ("utf-8",)),
}


def written(folder: Path, head: str, *columns: object, encoding: str = "utf-8") -> Path:
    """A log of those columns, of numbers or words, below its line of names; with semicolons, commas are decimal."""
    sign = ";" if ";" in head else ","
    spelled = [[one if isinstance(one, str) else f"{one:.7g}" for one in column] for column in columns]  # type: ignore[attr-defined]
    rows = (sign.join(row) for row in zip(*spelled, strict=True))
    rows = (row.replace(".", ",") for row in rows) if sign == ";" else rows
    path = folder / "log.csv"
    path.write_bytes("\n".join([head, *rows, ""]).encode(encoding))
    return path


def energies_mJ(loops: tuple[SampledLoop, ...]) -> list[float]:
    """The loops' areas."""
    return [1e-3 * enclosed_area(loop.displacement_um, loop.tangential_force_N) for loop in loops]


@pytest.mark.parametrize(
    ("language", "encoding"), [(name, own) for name, (_, encodings) in LANGUAGES.items() for own in encodings]
)
def test_names_of_many_languages_and_encodings_are_known(tmp_path: Path, language: str, encoding: str) -> None:
    path = written(tmp_path, LANGUAGES[language][0], TIME, X, FORCE, 2.0 + 0.0 * X, encoding=encoding)
    loops = read_loops(path)
    assert energies_mJ(loops) == pytest.approx([energy_mJ()] * 4, rel=0.01)
    assert np.all(loops[0].normal_load_N == 2.0)
    assert loops[0].time_s is not None
    assert guessing.guessed_mapping([path], {}, NO_WIRES).tables["conditions"]["normal_load_N"] == 2


@pytest.mark.parametrize("encoding", ["cp1252", "utf-8", "gbk"])
def test_words_that_nothing_distinguishes_are_read_as_before(encoding: str) -> None:
    head = "位移（毫米）" if encoding == "gbk" else "Prüfkörper;Maß"
    assert encoding_of(head.encode(encoding)) == {"gbk": "gb18030"}.get(encoding, encoding)


def test_an_amplitude_that_looks_like_another_units_is_asked_for(tmp_path: Path) -> None:
    path = written(tmp_path, "time_s,Stroke position (um),force_N,normal_N", TIME, 1e-3 * X, FORCE, 2.0 + 0.0 * X)
    found = guessing.guessed_mapping([path], {}, NO_WIRES)
    assert found.tables["conditions"]["displacement_amplitude_um"] == "?"
    assert "it looks like millimetres" in " ".join(found.remarks)


def test_unknown_names_in_an_encoding_that_was_guessed_are_listed_with_the_option(tmp_path: Path) -> None:
    path = written(tmp_path, "ABC;кол;дол", TIME, X, FORCE, encoding="cp1251")
    with pytest.raises(RecordError, match=r"--displacement COLUMN:UNIT, or another --encoding than cp1252, which is a"):
        read_loops(path)
    message = " ".join(guessing.guessed_mapping([path], {}, NO_WIRES).remarks)
    assert "the encoding cp1252 is a guess" in message


MISSING = (
    *("OVLD", "OL", "-OL", "1.#INF", "-1.#IND00", "1.#QNAN", "#N/A", "#NV", "#DIV/0!", "inf", "-Infinity", "Overflow"),
    *("+Over", "NaN", "-nan(ind)", "n.a.", "–", "####", "Overrange", "INVALID", "<NA>", "(null)", "9.9E37", "-9.9e+37"),
)


@pytest.mark.parametrize("word", MISSING)
@pytest.mark.parametrize("place", [0, 2])
def test_words_for_a_reading_that_is_none_leave_out_their_samples_alone(tmp_path: Path, word: str, place: int) -> None:
    forces = [f"{force:.4f}" for force in FORCE]
    forces[80] = forces[81] = forces[300] = word
    columns = (forces, X, TIME) if place == 0 else (TIME, X, forces)
    names = ["Time (s)", "Displacement (um)", "Force (N)"]
    loops = read_loops(written(tmp_path, ",".join(names[::-1] if place == 0 else names), *columns))
    assert sum(loop.displacement_um.size for loop in loops) == X.size - 3
    assert energies_mJ(loops) == pytest.approx([energy_mJ()] * 4, rel=0.01)
    assert "3 samples without a number were left out" in loops[0].notes


def test_another_word_among_numbers_is_named_with_its_line(tmp_path: Path) -> None:
    forces = [f"{force:.4f}" for force in FORCE]
    forces[80] = forces[81] = "gestört"
    path = written(tmp_path, "Time (s),Displacement (um),Force (N)", TIME, X, forces)
    with pytest.raises(RecordError, match=r"line 82, column Force \(N\): 'gestört' is no number"):
        read_loops(path)


@pytest.mark.parametrize(
    ("head", "columns"),
    [
        ("Time (s),Force (V),Force (N),Displacement (V),Displacement (mm)", (FORCE / 5.0, FORCE, 4.0 + X, 1e-3 * X)),
        ("Time (s),Force,Force (N),Displacement,Displacement (mm)", (FORCE / 5.0, FORCE, 4.0 + X, 1e-3 * X)),
        ("Time (s),Force (mV),Force scaled (N),Disp (counts),Disp scaled (mm)", (FORCE, FORCE, 400 * X, 1e-3 * X)),
        ("Time,Force,Force,Displacement,Displacement\ns,V,N,V,mm", (FORCE / 5.0, FORCE, 4.0 + X, 1e-3 * X)),
        ("Time (s),Force (N),Force (mN),Displacement (um),Displacement (mm)", (FORCE, 1e3 * FORCE, X, 1e-3 * X)),
    ],
    ids=["volts", "no unit", "scaled", "units below", "two units"],
)
def test_a_channel_with_a_physical_unit_beats_its_raw_twin(
    tmp_path: Path, head: str, columns: tuple[object, ...]
) -> None:
    path = written(tmp_path, head, TIME, *columns)
    loops = read_loops(path)
    assert energies_mJ(loops) == pytest.approx([energy_mJ()] * 4, rel=0.01)
    assert not any("is taken" in note for note in loops[0].notes)
    mapping = guessing.guessed_mapping([path], {}, NO_WIRES)
    assert mapping.tables["loops"]["columns"]["tangential_force_N"]["unit"] in ("N", "mN")


def test_a_channel_whose_zero_was_set_is_taken_for_the_other_with_a_word(tmp_path: Path) -> None:
    path = written(tmp_path, "Time (s),Displacement (um),Force (N),Force tared (N)", TIME, X, FORCE + 5.0, FORCE)
    loops = read_loops(path)
    assert energies_mJ(loops) == pytest.approx([energy_mJ()] * 4, rel=0.01)
    message = "log.csv: 'Force tared (N)' is taken for the force, and not 'Force (N)'"
    assert message in loops[0].notes
    assert message in looked_into(path).remarks
    chosen = read_loops(path, force="Force (N):N")
    assert float(np.mean(chosen[0].tangential_force_N)) == pytest.approx(5.0, abs=0.1)
    assert message not in chosen[0].notes


def test_a_load_in_another_unit_than_its_name_says_is_found_from_loops_alone(tmp_path: Path) -> None:
    path = written(tmp_path, "Displacement (um),Force (N),Load (N)", X, FORCE, 2000.0 + 0.0 * X)
    message = remarks(analyse_loops(read_loops(path)))
    assert any("times the normal load, which no dry friction gives" in one for one in message)
    assert not any("dry friction" in one for one in remarks(analyse_loops(read_loops(path, normal_load="2"))))


def test_of_two_columns_of_one_name_and_unit_neither_is_taken() -> None:
    assert recognised(["Force (N)", "Force (N)"], "force") == []
    assert recognised(["Force (V)", "Force (N)", "Friction force (N)"], "force") == [2, 1]


@pytest.mark.parametrize("name", ["Force x10 (N)", "Force (N) x 10", "Force [10^-1 N]", "Force/10 (N)", "Force 10 N"])
def test_a_factor_in_a_name_is_neither_passed_over_nor_read_as_one(tmp_path: Path, name: str) -> None:
    path = written(tmp_path, f"Elapsed (ms),Displacement (um),{name}", 1e3 * TIME, X, 10.0 * FORCE)
    with pytest.raises(RecordError, match="states a factor"):
        read_loops(path)
    with pytest.raises(RecordError, match="no unit"):
        read_loops(path, force=name)
    chosen = read_loops(path, force=f"{name}:N")
    assert chosen[0].time_s is not None
    assert energies_mJ(chosen) == pytest.approx([10.0 * energy_mJ()] * 4, rel=0.01)
    assert any("states a factor" in message for message in looked_into(path).remarks)


@pytest.mark.parametrize("sign", [",", ";", "\t"])
def test_comments_between_rows_are_no_rows_and_other_words_are_named_with_their_line(tmp_path: Path, sign: str) -> None:
    rows = [sign.join(f"{one:.6g}" for one in row) for row in zip(TIME, X, FORCE, strict=True)]
    for place, comment in ((333, "! T = 23.5, 41 %"), (222, "# why?"), (5, "// 2, 3"), (1, "# --- first, 1 ---")):
        rows.insert(place, comment)
    path = tmp_path / "log.txt"
    path.write_text("\n".join([sign.join(["Time (s)", "Displacement (um)", "Force (N)"]), *rows]))
    assert energies_mJ(read_loops(path)) == pytest.approx([energy_mJ()] * 4, rel=0.01)
    rows.insert(100, "Pump on")
    path.write_text("\n".join([sign.join(["Time (s)", "Displacement (um)", "Force (N)"]), *rows]))
    with pytest.raises(RecordError, match="line 102"):
        read_loops(path)
