"""Usual names of channels and units in many languages, and the encoding of a text found by them.

A channel is a measured quantity such as "force" or "displacement", a key of `USUAL_NAMES`. A stem is a column's name
without its unit, in plain letters with _ between words.
"""

import codecs
import re
import tomllib
import unicodedata
from collections.abc import Sequence
from pathlib import Path

from wirewear.base.units import FIELD_UNITS, UNITS_PER_LENGTH

#: Letters that are no other letter with an accent, and yet are written as one.
_LETTERS = str.maketrans({"ł": "l", "ø": "o", "đ": "d", "ı": "i", "æ": "ae", "œ": "oe"})


#: Units of what a sensor gives before it is scaled, or of nothing but a count.
RAW_UNITS = frozenset(("V", "mV", "A", "mA", "%", "counts", "count", "pts", "a.u.", "Ohm", "Ω", "µm/m"))

#: Units that loggers write, as they write them; those of channels that no record takes among them.
KNOWN_UNITS = RAW_UNITS.union(
    (unit for table in (FIELD_UNITS, UNITS_PER_LENGTH) for units in table.values() for unit in units),
    ("W", "Pa", "kPa", "MPa", "GPa", "bar", "mbar", "Hz", "kHz", "°C", "C", "K", "%RH", "rad", "deg", "°", "mm3"),
    ("mm/s", "um/s", "µm/s", "m/s", "rpm", "1/min", "U/min", "min-1", "1/s", "cycles", "Zyklen", "ciclos"),
    ("hh:mm:ss", "hh:mm:ss.sss", "s.ms"),
)

#: Unit of the record in which each channel is kept.
UNIT_OF = {
    **dict.fromkeys(("displacement", "x", "y", "height", "depth", "displacement amplitude", "slip amplitude"), "um"),
    **dict.fromkeys(("force", "normal load", "largest force"), "N"),
    "time": "s",
    "energy": "mJ",
}

#: What stands beside a usual name and does not change what is measured: a sensor, a channel's number, "measured".
_BESIDE = frozenset(
    ("ch", "channel", "kanal", "canal", "voie", "ai", "sensor", "transducer", "capteur", "aufnehmer", "signal", "gauge")
    + ("measured", "measurement", "actual", "running", "ist", "mesure", "gemessen", "gemessene", "medido", "medida")
    + ("scaled", "calibrated", "filtered", "skaliert", "gefiltert")
)

#: What stands beside the name of a channel whose zero was set.
_TARED = frozenset(
    ("tared", "zeroed", "net", "netto", "corrected", "compensated", "tariert", "genullt", "korrigiert", "tarado")
    + ("tarada", "taree", "tare", "corrigee", "corrige", "corregida", "corregido", "tarowana")
)

#: What stands beside the name of what is counted.
_COUNTED = frozenset(
    ("label", "no", "nr", "num", "number", "nummer", "numero", "index", "id", "count", "counter", "zahler", "total")
    + ("elapsed", "current", "block", "of", "de", "name", "n°", "№", "番号", "编号", "번호")
)
_RATE = re.compile(r"_(?:default_sample_rate|standardmessrate)$")

#: What loggers, profilometers, spreadsheets and C's libraries write where nothing was measured, or more than a range.
MISSING = re.compile(
    r"\*+|[-–—]+|no ?data|[-+]?nan(?:\(\w*\))?|<?n\.?/?a\.?>?|\(?null\)?|none|bad|invalid|missing|error|burn-?out|"
    r"#[^\W\d_][\w/]*[!?]?|#{2,}|[-+]?1[.,]#[a-z]+\d*|[-+]?inf(?:inity)?|"
    r"[-+<>]*(?:(?:over|under)[ _-]?(?:flow|range|load)?|ovl?d?|ovr(?:ng|flow)?|ofl|ufl|o\.?l\.?)",
    re.IGNORECASE,
)

#: A power of ten in a column's name by which its numbers are to be multiplied or divided: ``"Force x10 (N)"``.
_FACTOR = re.compile(
    r"(?:^|[\s_(\[)\]])[x×*·/]\s?(?:10+|10\s?\^\s?[-+]?\d+|1e[-+]?\d+|0[.,]0*1)(?!\d)|"
    r"[^\W_]\s?[*×·/]\s?10+(?!\d)|(?<!\d)1\s?/\s?10+(?!\d)|(?<!\w)10+\s?[x×*·]|"
    r"(?:^|[\s_(\[])(?:10+|0[.,]0*1|10\s?\^\s?[-+]?\d+)[\s_]?[^\W\d_]+[)\]]?$",
    re.IGNORECASE,
)

#: A line that begins with a word, which is none of those for what is missing.
WORDS = re.compile(
    rf"^[ \t]*[\"#%/;*\[=<({{-]*[ ]*(?!(?:{MISSING.pattern})\"?[ ]*(?:[\t;,]|$|[ ][-+.\d]))[^\W\d_]",
    re.IGNORECASE | re.MULTILINE,
)

#: Encodings of texts that are none in UTF-8, the likeliest first where the words of none are known.
_ENCODINGS = (
    *("cp1252", "cp932", "cp1251", "cp1250", "gb18030", "cp949", "big5", "euc_jp", "iso8859_2", "koi8_r"),
    *("cp1254", "cp1253", "cp866", "cp850", "cp852"),
)
_HEAD_bytes = 20_000  #: In which the names of columns stand.


def plain(text: str) -> str:
    """Text in lower case and without accents."""
    signs = unicodedata.normalize("NFKD", unicodedata.normalize("NFKD", text).casefold()).translate(_LETTERS)
    return "".join(sign for sign in signs if not unicodedata.combining(sign))


#: Usual names of a channel, the most usual first.
USUAL_NAMES: dict[str, list[str]] = {
    channel: [plain(name) for name in names]
    for channel, names in tomllib.loads(
        Path(__file__).with_name("usual_names.toml").read_text(encoding="utf-8")
    ).items()
}
_WORDS = frozenset(
    word for names in USUAL_NAMES.values() for name in names for word in re.findall(r"[^\W\d_]+", name) if len(word) > 1
)


#: Units that are written out or in other letters, in the singular and without accents, and how a mapping writes them.
_WRITTEN_OUT = {
    plain(word): unit
    for unit, words in {
        "s": "second seconde sekunde sekunden sekunda sekundy segundo sec 秒 초 с сек секунда секунды",
        "ms": "millisecond milliseconde millisekunde millisekunden milisegundo milisekunda 毫秒 ミリ秒 밀리초 мс",
        "us": "мкс", "min": "мин", "h": "ч",
        "N": "newton niuton 牛 牛顿 牛頓 ニュートン 뉴턴 н", "mN": "мн", "kN": "кн", "uN": "мкн",
        "g": "г", "gf": "гс", "kg": "кг", "kgf": "кгс",
        "um": "micron micrometer micrometre mikrometer mikrometr micrometro 微米 ミクロン マイクロメートル мкм",
        "mm": "millimeter millimetre milimetro milimetr 毫米 ミリメートル ミリ 밀리미터 мм",
        "nm": "nanometer nanometre nanometro 纳米 ナノメートル 나노미터 нм", "cm": "см", "m": "м", "Å": "angstrom a˚",
        "V": "volt voltio 伏 ボルト 볼트 в", "mV": "мв", "Hz": "гц", "J": "дж", "mJ": "мдж",
    }.items()
    for word in words.split()
}  # fmt: skip


def usual_unit(unit: str) -> str:
    """Unit as mappings write it ("s" for "seconds"); a unit that is not known is returned unchanged."""
    if unit in KNOWN_UNITS:
        return unit
    joined = unicodedata.normalize("NFKC", unit)
    return joined if joined in KNOWN_UNITS else _WRITTEN_OUT.get(plain(unit).removesuffix("s"), unit)


def states_factor(name: str) -> bool:
    """True if a column's name states a power of ten by which its numbers are to be multiplied or divided."""
    return _FACTOR.search(unicodedata.normalize("NFKC", name)) is not None


def units_of(channel: str) -> dict[str, float]:
    """Units in which loggers write a channel, those per length of a line contact among them, with the factor from each
    to the unit in which records keep the channel; empty for a channel without unit.
    """
    unit = UNIT_OF.get(channel, "")
    return FIELD_UNITS.get(unit, {}) | UNITS_PER_LENGTH.get(unit, {})


def stem_and_unit(name: str, known: dict[str, float]) -> tuple[str, str | None]:
    """Stem of a column's name, and its unit, None if it states none of the known ones: ``("tangential_force", "N")``
    for ``"Tangential force [N]"``.

    known: units that count, by name; other values are not read.
    """
    name = unicodedata.normalize("NFKC", name).lstrip("#%/; ")
    bracketed = re.fullmatch(r"(.+?)[\s_]*[\[(]\s*([^\[\]()]+?)\s*[\])]", name)
    match = bracketed or re.fullmatch(r"(.+?)(?:,\s+|[\s_/]*[_\[(\s/]\s*)([^\s_\[\]()/]+)\s*[\])]?", name)
    stated = usual_unit(match[2]) if match else ""
    stem, unit = (match[1], stated) if match and stated in known else (name, None)
    if unit is None and bracketed and usual_unit(bracketed[2]) in KNOWN_UNITS:
        stem = bracketed[1]
    stem = re.sub(r"[\s_.\-]+", "_", plain(stem).strip())
    return stem.removesuffix("_in") if unit else stem, unit


def recognised(names: Sequence[str], channel: str, units: Sequence[str] = ()) -> list[int]:
    """Indices of the columns (by their names) that may hold a channel, the likeliest first; empty if none does.

    Names that are exactly usual ones come before those with other words beside, and more usual names before others. Of
    columns with equal names, one in a unit of the channel is preferred to a raw signal, and a zeroed one to one that
    was not zeroed. units: stated unit of each column ("" if unstated); if empty, the units in the names.
    """
    known, parted = units_of(channel), [stem_and_unit(name, units_of(channel)) for name in names]
    own = list(units) or [unit or "" for _, unit in parted]
    physical = [unit in known for unit in own]
    plain_names = [not states_factor(name) for name in names]
    beside = _BESIDE if channel in UNIT_OF else _BESIDE | _COUNTED
    parts = [re.split(r"[_()]+", stem) for stem, _ in parted]
    tared = [not _TARED.isdisjoint(words) for words in parts]
    exact = ["_".join(word for word in words if word and word not in _TARED) for words in parts]
    bare = [_alone(word, beside) for word in exact]
    found = list[int]()
    for words in (exact, bare):
        for name in USUAL_NAMES[channel]:
            alike = [place for place, word in enumerate(words) if word == name and plain_names[place]]
            if alike and not any(physical[place] for place in alike):
                like = (place for place, word in enumerate(bare) if word == name and plain_names[place])
                alike += [place for place in like if place not in alike]
            for better in (physical, tared):
                alike = [place for place in alike if better[place]] or alike
            # Of two columns of one name and unit, one is as likely as the other; times of several channels are alike.
            distinct = len({own[place] for place in alike}) == len(alike)
            if alike and (distinct or channel == "time"):
                found.append(alike[0])
    return list(dict.fromkeys(found))


def _alone(stem: str, beside: frozenset[str]) -> str:
    """Name without sensor words and numbers: ``"displacement"`` for ``"ch_1_displacement"``."""
    words = [word.removesuffix("aufnehmer") for word in re.split(r"[_/]", _RATE.sub("", stem))]
    return "_".join(dict.fromkeys(word for word in words if word not in beside and not re.fullmatch(r"\W*\d*", word)))


def encoding_of(data: bytes) -> str:
    """Name of the most likely encoding of a text, as Python calls it: the one in which most of its words are known."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        runs = re.findall(rb"[\x80-\xff]+", data)
        # Chinese signs stand in pairs of bytes, several at a time, or are full-width brackets (0xA3 ..); letters of
        # the West stand alone among others.
        paired = all(len(run) % 2 == 0 for run in runs) and any(len(run) > 3 or run[0] == 0xA3 for run in runs)
        head = data[: data.find(b"\n", _HEAD_bytes)] if len(data) > _HEAD_bytes else data
        return max(("gb18030", *_ENCODINGS) if paired else _ENCODINGS, key=lambda encoding: _known(head, encoding))
    return "utf-8-sig" if data.startswith(codecs.BOM_UTF8) else "utf-8"


def _known(head: bytes, encoding: str) -> int:
    """Number of usual words in a text under this encoding; -1 if it cannot be decoded."""
    try:
        words = re.findall(r"[^\W\d_]+", plain(head.decode(encoding)))
    except UnicodeDecodeError:
        return -1
    return sum(word in _WORDS for word in words)
