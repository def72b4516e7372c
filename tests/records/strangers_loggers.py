"""Logs as the programs of loggers, oscilloscopes and testing machines export them, in the words of two languages."""

import io
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from geometry.arrays import Array
from tests.records.strangers_files import (
    CONDITIONS,
    CYCLES,
    ENGLISH,
    FORCE,
    LOAD_N,
    NORMAL,
    SAMPLES,
    TIME,
    VOLTS,
    FREQUENCY_Hz,
    Language,
    Written,
    X,
    blanks_between,
    headed,
    line,
    numbered,
    of_language,
    plain,
    table,
)

_RATE_Hz = SAMPLES * FREQUENCY_Hz
_EMPTY = [""] * X.size
_SETTINGS = ["Record Length", "Source", *_EMPTY[2:]], ["512", "CH1", *_EMPTY[2:]], _EMPTY
_DEWESOFT = f"Data export\nSample rate:\t{_RATE_Hz:g} Hz\n\nData1\n"


def log(head: str, columns: Sequence[Any], own: Language, encoding: str = "cp1252", **more: Any) -> Written:
    """A log whose columns are parted by tabs."""
    known = {} if more.pop("pressed", False) else {"normal_load_N": 2.0}
    text = head + table(columns, own, delimiter="\t")
    return Written({"log.txt": text.encode(encoding)}, known | more.pop("known", {}), **more)


def tabbed(head: str, *columns: Any, encoding: str = "cp1252") -> Callable[[Language], Written]:
    """Columns below a head whose braces hold the language's words, parted by tabs."""
    return lambda own: log(head.format_map(vars(own)), columns or (TIME, X, FORCE), own, encoding)


def catman(own: Language) -> Written:
    """A measuring amplifier's export: sensors beside the names, the rate beside that of time."""
    names = ("Time  1 - default sample rate", "Displacement sensor 1", "Force transducer 2")
    if own is not ENGLISH:
        names = ("Zeit  1 - Standardmessrate", "Wegaufnehmer 1", "Kraftaufnehmer 2")
    head = "HBM_CATMAN_DATAFILE_40\n\nTest: 7\n\n" + "\t".join(names) + "\ns\tµm\tN\n"
    return log(head, (TIME, X, FORCE), own)


def dasylab(own: Language) -> Written:
    """Dates, times of day and a head that names the blocks."""
    clocks = [f"12:21:{t:07.4f}".replace(".", own.decimal) for t in 8.029 + TIME]
    name = "Measurement time" if own is ENGLISH else "Messzeit"
    head = f"DASYLab - V 13.0\nDelta: 0.0026 sec.\nDate\t{name}[hh:mm:ss]\t{own.displacement} [mm]\t{own.force} [N]\n"
    return log(head, (["12.05.2022"] * X.size, clocks, 1e-3 * X, FORCE), own)


def testing_machine(own: Language) -> Written:
    """Channels numbered; the only force is called a load, and changes its sign."""
    unit = "Sec" if own is ENGLISH else "Sekunden"
    head = f"MTS793|MPT|ENU|1\n\nRunning {own.time}\tCh 1 {own.displacement}\tCh 1 Load\n{unit}\tmm\tN\n"
    return log(head, (TIME, 1e-3 * X, FORCE), own)


def units_written_out(own: Language) -> Written:
    """Units by their names."""
    units = "seconds\tmicrons\tnewtons" if own is ENGLISH else "secondes\tmicromètres\tNewtons"
    names = f"{own.time}\t{own.displacement}\t{own.force}"
    return log(f"{names}\n{units}\n", (TIME, X, FORCE), own, "utf-8")


def signs(encoding: str) -> Callable[[Language], Written]:
    """Names in the language's own signs, with its brackets."""

    def written(own: Language) -> Written:
        names = (own.time, own.displacement, own.force, own.normal)
        units = ("s", "mm", "N", "mN")
        head = "\t".join(f"{name}（{unit}）" for name, unit in zip(names, units, strict=True)) + "\n"
        return log(head, (TIME, 1e-3 * X, FORCE, 1e3 * NORMAL), own, encoding, pressed=True)

    return written


def steps(own: Language) -> Written:
    """A tribometer's programme: it presses, rubs and lifts off, each step a table with a head of its own."""
    still = np.zeros(300)
    parts = ((still, still, np.linspace(0.0, 2.0, 300)), (X, FORCE, NORMAL), (still, still, np.linspace(2.0, 0.0, 300)))
    text = "Created by Data Viewer ver.2.19\nTotal number of runs - 1\n\n"
    for number, (x, force, normal) in enumerate(parts, 1):
        text += f"Step No. {number}\nVelocity     = 240\nData Count   = {x.size}\n\n"
        text += line(own, "Fx", "Fz", "Y", "T") + line(own, "N", "N", "mm", "sec") + "\n"
        text += table((force, -normal, 1e-3 * x, np.arange(x.size) / _RATE_Hz), own) + "\n"
    return Written({"log.csv": text.encode()})


def statistics_below(own: Language) -> Written:
    """Means and extremes in the last lines."""
    head = line(own, f"{own.time} (s)", f"{own.displacement} (um)", f"{own.force} (N)")
    below = line(own, "Mean", "0", "0") + line(own, "Max", "60", "1")
    return Written({"log.csv": f"{head}{table((TIME, X, FORCE), own)}\n{below}".encode()}, {"normal_load_N": 2.0})


def counted_from(epoch: float, unit_s: float, unit: str) -> Callable[[Language], Written]:
    """Times without a unit, counted from long ago."""

    def written(own: Language) -> Written:
        times = [f"{epoch + t / unit_s:.17g}".replace(".", own.decimal) for t in TIME]
        head = line(own, own.time, f"{own.displacement} (um)", f"{own.force} (N)")
        answers = {"time_s": f'{{ column = "{own.time}", unit = {unit} }}', "frequency_Hz": f"{FREQUENCY_Hz}"}
        return plain(head, (times, X, FORCE), own, answers=answers)

    return written


def rows_of(values: Array, own: Language) -> str:
    """One cycle a row."""
    return table(list(values.reshape(CYCLES, SAMPLES).T), own)


def groups_of_columns(own: Language) -> Written:
    """One cycle a row: its number, samples of the displacement, samples of the force."""
    numbers = range(1, SAMPLES + 1)
    names = [f"{name} {n} ({unit})" for name, unit in ((own.displacement, "um"), (own.force, "N")) for n in numbers]
    cells = [np.arange(1.0, CYCLES + 1), *(own for both in (X, FORCE) for own in both.reshape(CYCLES, SAMPLES).T)]
    text = line(own, own.cycle, *names) + table(cells, own)
    return Written({"log.csv": text.encode()}, {"normal_load_N": 2.0, "frequency_Hz": FREQUENCY_Hz})


def groups_without_names(own: Language) -> Written:
    """A log whose columns have neither names nor numbers."""
    cells = [one for both in (X, FORCE) for one in both.reshape(CYCLES, SAMPLES).T]
    answers = {
        "displacement_um": of_language(f"1:{SAMPLES}", "um"),
        "tangential_force_N": of_language(f"{SAMPLES + 1}:{2 * SAMPLES}", "N"),
    }
    known = {"normal_load_N": 2.0, "frequency_Hz": FREQUENCY_Hz}
    return Written({"log.csv": table(cells, own).encode()}, known, answers | CONDITIONS)


def file_a_channel(own: Language) -> Written:
    """One cycle a row, and a file for each channel, named after it."""
    files = {f"{own.displacement}_um.csv": rows_of(X, own), f"{own.force}_N.csv": rows_of(FORCE, own)}
    known = {"normal_load_N": 2.0, "frequency_Hz": FREQUENCY_Hz}
    return Written({name: text.encode() for name, text in files.items()}, known)


def file_a_channel_timed(own: Language) -> Written:
    """A file of times and displacements, and one of times and forces."""
    channels = {f"{own.displacement} (mm)": 1e-3 * X, f"{own.force} (N)": FORCE}
    files = {
        f"channel{n}.csv": (line(own, f"{own.time} (s)", name) + table((TIME, values), own)).encode()
        for n, (name, values) in enumerate(channels.items())
    }
    return Written(files, {"normal_load_N": 2.0})


def excel(own: Language) -> Written:
    """A spreadsheet with a title above and another sheet before it."""
    import openpyxl

    book = openpyxl.Workbook()
    cover = book.active
    assert cover is not None
    cover.append(["Report", 7])
    sheet = book.create_sheet("Data")
    for row in (["Test 7"], [], [own.time, own.displacement, own.force], ["s", "mm", "N"]):
        sheet.append(row)
    for numbers in zip(TIME.tolist(), (1e-3 * X).tolist(), FORCE.tolist(), strict=True):
        sheet.append(numbers)
    stream = io.BytesIO()
    book.save(stream)
    return Written({"test.xlsx": stream.getvalue()}, {"normal_load_N": LOAD_N})


def tdms(own: Language) -> Written:
    """LabVIEW's binary file, with units and the step of time as properties."""
    from nptdms import ChannelObject, TdmsWriter

    stream = io.BytesIO()
    step = {"wf_increment": 1.0 / (SAMPLES * FREQUENCY_Hz)}
    channels = [
        ChannelObject("Log", own.displacement, 1e-3 * X, properties=step | {"unit_string": "mm"}),
        ChannelObject("Log", own.force, FORCE, properties=step | {"unit_string": "N"}),
    ]
    with TdmsWriter(stream) as writer:
        writer.write_segment(channels)
    return Written({"test.tdms": stream.getvalue()}, {"normal_load_N": LOAD_N})


#: The kinds by their names.
LOGGERS: dict[str, Callable[[Language], Written]] = {
    "xlsx": excel,
    "TDMS": tdms,
    "catman": catman,
    "Dewesoft": tabbed(f"{_DEWESOFT}{{time}} (s)\tAI 1/{{displacement}} (µm)\tAI 2/{{force}} (N)\n", encoding="utf-8"),
    "DASYLab": dasylab,
    "testing machine": testing_machine,
    "units written out": units_written_out,
    "own signs in UTF-8": signs("utf-8"),
    "own signs in GBK": signs("gbk"),
    **{
        f"names after {mark}": blanks_between("log.dat", f"{mark} test 7\n{mark} t [s]  x [um]  Q [N]\n", " ")
        for mark in "#%"
    },
    "T in °C": tabbed("T (°C)\tx (um)\tQ (N)\tt (s)\n", 20.0 + 0.0 * X, X, FORCE, TIME),
    # Times count from the trigger.
    "oscilloscope": headed(
        "x-axis|1|2\nsecond|Volt|Volt\n", TIME - 0.5, X / 12.0, FORCE / 0.5, answers=numbered(2, 3, *VOLTS) | CONDITIONS
    ),
    "settings beside the numbers": headed(
        "", *_SETTINGS, TIME, X, FORCE, answers=numbered(5, 6, '"um"', '"N"') | CONDITIONS
    ),
    "steps of a programme": steps,
    "statistics below": statistics_below,
    "one cycle a row": groups_of_columns,
    "one cycle a row without names": groups_without_names,
    "one cycle a row, one file a channel": file_a_channel,
    "one file a channel": file_a_channel_timed,
    "days since 1900": counted_from(44693.5, 86400.0, '"s", factor = 86400.0'),
    "milliseconds since 1970": counted_from(1652357000000.0, 1e-3, '"ms"'),
}
