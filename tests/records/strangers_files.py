"""Files as laboratories write them, in the words of two languages, of loops, a scar and an evolution that are known.

Each writer takes a `Language` and gives names, contents, what the user says, and what is to be filled in afterwards.
"""

import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from geometry.arrays import Array

SAMPLES, CYCLES, FREQUENCY_Hz, LOAD_N, AMPLITUDE_um = 128, 4, 3.0, 2.0, 60.0
STIFFNESS_N_per_um, FRICTION = 0.167, 0.62
GRAM_N, INCH_um, POUND_N = 9.80665e-3, 25400.0, 4.4482216152605


@dataclass(frozen=True)
class Language:
    """Words and signs of a country."""

    displacement: str
    force: str
    normal: str
    time: str
    cycle: str
    delimiter: str
    decimal: str


ENGLISH = Language("Displacement", "Friction force", "Normal force", "Time", "Cycle", ",", ".")
GERMAN = Language("Weg", "Reibkraft", "Normalkraft", "Zeit", "Zyklus", ";", ",")
SPANISH = Language("Desplazamiento", "Fuerza tangencial", "Fuerza normal", "Tiempo", "Ciclo", ";", ",")
CHINESE = Language("位移", "摩擦力", "法向力", "时间", "循环次数", ",", ".")
FRENCH = Language("Déplacement", "Force tangentielle", "Force normale", "Temps", "Cycle", ";", ",")


@dataclass(frozen=True)
class Written:
    """Files by name, the options that the user gives, and what is put in place of what is left open, by key."""

    files: Mapping[str, bytes]
    known: Mapping[str, Any] = field(default_factory=dict)
    answers: Mapping[str, str] = field(default_factory=dict)
    amplitudes_um: Sequence[float] = (AMPLITUDE_um,) * CYCLES
    scars: bool = False
    evolution: bool = False


def loops(amplitudes_um: Sequence[float] = (AMPLITUDE_um,) * CYCLES) -> tuple[Array, Array, Array]:
    """Time [s], displacement [µm] and force [N] of a slider on a spring, elastic and perfectly plastic, with noise."""
    phase = 2.0 * np.pi * np.arange(SAMPLES * len(amplitudes_um)) / SAMPLES
    x = np.repeat(amplitudes_um, SAMPLES) * np.sin(phase)
    limit, force, forces = FRICTION * LOAD_N, 0.0, []
    for step in np.diff(np.concatenate([x[:SAMPLES], x]), prepend=0.0):
        force = float(np.clip(force + STIFFNESS_N_per_um * step, -limit, limit))
        forces.append(force)
    noise = 0.002 * np.random.default_rng(4).standard_normal(x.size)
    return np.arange(x.size) / (SAMPLES * FREQUENCY_Hz), x, np.array(forces[SAMPLES:]) + noise


TIME, X, FORCE = loops()
NORMAL = np.full(X.size, LOAD_N)


def energy_mJ(amplitude_um: float = AMPLITUDE_um) -> float:
    """Energy of one loop in closed form: 4 Q (δa − Q/K)."""
    limit = FRICTION * LOAD_N
    return 4e-3 * limit * (amplitude_um - limit / STIFFNESS_N_per_um)


def table(columns: Sequence[Array | Sequence[str]], own: Language, *, delimiter: str = "") -> str:
    """Rows of numbers, or of texts as they are."""
    spelled = [
        [one if isinstance(one, str) else f"{one:.7g}".replace(".", own.decimal) for one in column]
        for column in columns
    ]
    return "\n".join((delimiter or own.delimiter).join(row) for row in zip(*spelled, strict=True)) + "\n"


def line(own: Language, *fields: str) -> str:
    """A line of the header."""
    return own.delimiter.join(fields) + "\n"


def plain(head: str, columns: Sequence[Any], own: Language, encoding: str = "utf-8", **more: Any) -> Written:
    """One text file of loops."""
    known = {"normal_load_N": LOAD_N} if more.pop("load", True) else {}
    return Written({"log.csv": (head + table(columns, own)).encode(encoding)}, known | more.pop("known", {}), **more)


def headed(head: str, *columns: Any, **more: Any) -> Callable[[Language], Written]:
    """Columns below a head, in which "|" parts fields and braces hold the language's words."""
    return lambda own: plain(head.format_map(vars(own)).replace("|", own.delimiter), columns, own, **more)


def blanks_between(file: str, head: str, blanks: str) -> Callable[[Language], Written]:
    """Columns that blanks part."""
    rows: Callable[[Language], str] = lambda own: table((TIME, X, FORCE), own, delimiter=blanks)  # noqa: E731
    return lambda own: Written({file: (head.format_map(vars(own)) + rows(own)).encode()}, {"normal_load_N": LOAD_N})


def bracketed(own: Language) -> Written:
    """Units in brackets in the names, or after a slash as German standards have them."""
    spelled = "{} / {}" if own is GERMAN else "{} [{}]"
    named = [(own.time, "ms"), (own.displacement, "mm"), (own.force, "mN")]
    return plain(line(own, *(spelled.format(*one) for one in named)), (1e3 * TIME, 1e-3 * X, 1e3 * FORCE), own)


def quoted(own: Language) -> Written:
    """Every field in quotation marks."""
    head = line(own, *(f'"{name}"' for name in (own.time, own.displacement, own.force)))
    head += line(own, '"(s)"', '"(mm)"', '"(N)"')
    rows = table((TIME, 1e-3 * X, FORCE), own)
    text = head + "\n".join(own.delimiter.join(f'"{one}"' for one in row.split(own.delimiter)) for row in rows.split())
    return Written({"log.csv": text.encode()}, {"normal_load_N": LOAD_N})


def umt(own: Language) -> Written:
    """A tribometer's export: gram-force, the normal force negative, the displacement called Y."""
    force = FORCE / GRAM_N
    head = "Created by Data Viewer ver.2.19\nTotal number of runs - 1\n\nStep No. 1\nVelocity     = 240\n"
    head += "Data Count   = 512\nStarted at: 12:21:58.029 12 May 2022\n\n"
    head += line(own, "Fx", "Fz", "Z", "Y", "T", "Ff", "COF") + line(own, "g", "g", "mm", "mm", "sec", "g", "") + "\n"
    columns = (force, -NORMAL / GRAM_N, -0.69 + 0 * X, 1e-3 * X, TIME, force, FORCE / LOAD_N)
    return plain(head, columns, own, load=False)


def clock(spelled: str, begin_s: float = 43258.5) -> Callable[[Language], Written]:
    """Times of day in place of a time."""

    def written(own: Language) -> Written:
        seconds = (begin_s + TIME) % 86400.0
        times = [spelled.format(f"{int(t // 3600):02d}:{int(t % 3600 // 60):02d}:{t % 60:09.6f}") for t in seconds]
        head = line(own, own.time, f"{own.displacement} (um)", f"{own.force} (N)")
        return plain(head, (times, X, FORCE), own)

    return written


def lvm(columns_of_time: str) -> Callable[[Language], Written]:
    """LabVIEW's measurement file with a time for all channels, for each, or none."""

    def written(own: Language) -> Written:
        step = f"{1.0 / (SAMPLES * FREQUENCY_Hz):.7g}".replace(".", own.decimal)
        names = ["X_Value", own.displacement, own.force]
        columns: list[Any] = [TIME, 1e-3 * X, FORCE]
        if columns_of_time == "Multi":
            names, columns = ["X_Value", names[1], "X_Value", names[2]], [TIME, columns[1], TIME, FORCE]
        elif columns_of_time == "No":
            columns[0] = [""] * X.size
        end = "***End_of_Header***\t\n"
        head = (
            f"LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t{own.decimal}\nX_Columns\t{columns_of_time}\n"
        )
        head += f"{end}\t\nChannels\t2\nSamples\t512\t512\nY_Unit_Label\tmm\tN\nX_Dimension\tTime\tTime\n"
        head += f"X0\t0\t0\nDelta_X\t{step}\t{step}\n{end}" + "\t".join([*names, "Comment"]) + "\n"
        text = head + table(columns, own, delimiter="\t")
        return Written({"test.lvm": text.encode()}, {"normal_load_N": LOAD_N})

    return written


def six_axis(own: Language) -> Written:
    """A sensor of six axes and a stage; the header states the rate and no unit."""
    rate = f"{SAMPLES * FREQUENCY_Hz:g}"
    head = line(own, "Sampling frequency [Hz]:" if own is ENGLISH else "Abtastrate [Hz]:", rate, "Track [mm]:", "4")
    head += line(own, "Fx", "Fy", "Fz", "Tx", "x-Position")
    answers = {
        "displacement_um": '{ column = "x-Position", unit = "um" }',
        "tangential_force_N": '{ column = "Fx", unit = "N" }',
        "normal_force_N": '{ column = "Fz", unit = "N", factor = -1.0 }',
        "displacement_amplitude_um": "60.0",
    }
    return plain(head, (FORCE, 0 * X, -NORMAL, 0.1 + 0 * X, X), own, answers=answers)


def matlab(
    variables: Callable[[Language], Mapping[str, Array]], answers: Mapping[str, str], version: str = "5"
) -> Callable[..., Written]:
    """A MATLAB file, whose variables have no units."""

    def written(own: Language) -> Written:
        from scipy.io import savemat

        stream = io.BytesIO()
        savemat(stream, dict(variables(own)), format=version)
        known = {"normal_load_N": LOAD_N, "frequency_Hz": FREQUENCY_Hz}
        more = {"displacement_amplitude_um": "60.0", "cycles": "4"}
        return Written({"test.mat": stream.getvalue()}, known, {**more, **answers})

    return written


def _ascii(name: str) -> str:
    return name.replace(" ", "_")


def vectors(own: Language) -> Mapping[str, Array]:
    """A vector a channel."""
    return {"t": TIME, _ascii(own.displacement): 1e-3 * X, _ascii(own.force): FORCE}


def cycle_a_row(own: Language) -> Mapping[str, Array]:
    """A matrix a channel, one cycle a row."""
    names = _ascii(own.displacement), _ascii(own.force)
    return {name: values.reshape(CYCLES, SAMPLES) for name, values in zip(names, (1e-3 * X, FORCE), strict=True)}


def of_language(column: str, unit: str) -> str:
    """A column filled in."""
    return f'{{ column = "{column}", unit = "{unit}" }}'


def evolution(own: Language) -> Written:
    """A table of a few figures a cycle."""
    named = ("Displacement amplitude", "Max tangential force", "Dissipated energy")
    if own is GERMAN:
        named = ("Wegamplitude", "Max. Reibkraft", "Dissipierte Energie")
    head = line(own, own.cycle, *(f"{name} [{unit}]" for name, unit in zip(named, ("um", "N", "mJ"), strict=True)))
    rows = (np.array([1.0, 2.0, 4.0]), np.array([60.0, 60.0, 60.1]), np.array([1.24, 1.25, 1.26]))
    text = head + table((*rows, np.array([0.2607, 0.2620, 0.2640])), own)
    log = bracketed(own)
    return Written({**log.files, "evolution.csv": text.encode()}, log.known, evolution=True)


_PARTS = {"displacement_um": of_language("hyst({})", "mm"), "tangential_force_N": of_language("hyst({})", "N")}


def _part(first: str, second: str) -> Mapping[str, str]:
    both = zip(_PARTS.items(), (first, second), strict=True)
    return {key: spelled.replace("{}", place) for (key, spelled), place in both}


def numbered(displacement: int | str, force: int | str, unit: str, other: str) -> dict[str, str]:
    """Columns filled in, and their units."""
    columns = {"displacement_um": (displacement, unit), "tangential_force_N": (force, other)}
    return {name: f"{{ column = {column}, unit = {own} }}" for name, (column, own) in columns.items()}


_NAMES = "{time}|{displacement}|{force}"
_RATE, _GROWING = {"frequency_Hz": FREQUENCY_Hz}, (20.0, 30.0, 45.0, 60.0)
CONDITIONS = {"displacement_amplitude_um": f"{AMPLITUDE_um}", "frequency_Hz": f"{FREQUENCY_Hz}", "cycles": f"{CYCLES}"}
VOLTS = '"V", factor = 12.0', '"V", factor = 0.5'
_IN_VOLTS = {"tangential_force_N": '{ column = 3, unit = "V", factor = 0.5 }'}

#: The kinds, and the languages beside English in which each is tried.
KINDS: dict[str, Callable[[Language], Written]] = {
    "units in brackets": bracketed,
    **{
        f"units line with {unit}": headed(f"{_NAMES}|Kanal 7\ns|um|N|{unit}\n", TIME, X, FORCE, 0.72 * NORMAL)
        for unit in ("mm/s", "bar", "rpm", "A", "counts", "°C")
    },
    "blank line before numbers": headed(f"{_NAMES}\ns|um|N\n\n", TIME, X, FORCE),
    "DATA line before numbers": headed(f"{_NAMES}\ns|um|N\nDATA\n", TIME, X, FORCE),
    "blank and DATA lines": headed(f"{_NAMES}\ns|um|N\n\n[Data]\n", TIME, X, FORCE),
    "all fields quoted": quoted,
    "UMT export": umt,
    "clock": clock("{}"),
    "clock with a date": clock("2022-05-12 {}"),
    "clock with a German date": clock("12.05.2022 {}"),
    "clock with AM and PM": clock("{} PM"),
    "clock past midnight": clock("{}", begin_s=86399.5),
    "rows of nothing at the end": headed(
        "{time} (s)|{displacement} (um)|{force} (N)\n", *(np.append(one, [np.nan] * 3) for one in (TIME, X, FORCE))
    ),
    "LVM, one time": lvm("One"),
    "LVM, a time a channel": lvm("Multi"),
    "LVM, no time": lvm("No"),
    "two columns without names": headed("", FORCE, 1e-4 * X, answers=numbered(2, 1, '"cm"', '"N"') | CONDITIONS),
    "no time and no cycle": headed("{displacement} (um)|{force} (N)\n", X, FORCE, known=_RATE),
    "growing amplitudes": headed(
        "{displacement} (um)|{force} (N)\n", *loops(_GROWING)[1:], known=_RATE, amplitudes_um=_GROWING
    ),
    "unknown names in volts": headed(
        "{time}|AI0|AI1\ns|V|V\n", TIME, X / 12.0, FORCE / 0.5, answers=numbered('"AI0"', '"AI1"', *VOLTS) | CONDITIONS
    ),
    "force in volts": headed("{time} [s]|{displacement} [um]|{force} [V]\n", TIME, X, FORCE / 0.5, answers=_IN_VOLTS),
    "six-axis sensor": six_axis,
    "inches and pounds in UTF-16": headed(
        "{time} (s)|{displacement} (in)|{force} (lbf)\n", TIME, X / INCH_um, FORCE / POUND_N, encoding="utf-16"
    ),
    # The force drives the motion.
    "Latin-1 and kilograms": headed(
        "{time} (s)|{displacement} (µm)|{force} (kg)\n", TIME, X, -FORCE / 9.80665, encoding="cp1252"
    ),
    "names with blanks": blanks_between("log.txt", "{time} (s)   {displacement} (um)   {force} (N)\n", "   "),
    "column of words": headed(f"{_NAMES}|Status\ns|um|N|\n", TIME, X, FORCE, ["OK"] * X.size),
    "MATLAB vectors": matlab(vectors, {}),
    "MATLAB 4 vectors": matlab(vectors, {}, "4"),
    "MATLAB channels as columns": matlab(lambda _: {"hyst": np.stack([1e-3 * X, FORCE], axis=1)}, _part(":,1", ":,2")),
    "MATLAB channels as rows": matlab(lambda _: {"hyst": np.stack([1e-3 * X, FORCE])}, _part("1,:", "2,:")),
    "MATLAB cycles as rows": matlab(cycle_a_row, {}),
    "evolution": evolution,
}


def write(written: Written, folder: Path) -> list[Path]:
    """The files in a folder."""
    for name, contents in written.files.items():
        (folder / name).write_bytes(contents)
    return [folder / name for name in written.files]
