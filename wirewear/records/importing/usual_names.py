"""Usual names of a logger's columns, in seven languages, and their units."""

import re
import unicodedata
from collections.abc import Sequence

from wirewear.base.errors import FIELD_UNITS, UNITS_PER_LENGTH
from wirewear.base.guessing import KNOWN_UNITS, plain, usual_unit

#: Usual names of a channel, without their unit and accents, in order of preference: English, German, Spanish, French,
#: Italian, Portuguese and Chinese, then those that may also name something else.
USUAL_NAMES: dict[str, tuple[str, ...]] = {
    "displacement": ("displacement", "relative_displacement", "disp", "delta", "position", "stroke", "lvdt", "x")
    + ("weg", "verschiebung", "auslenkung", "hub", "position_x", "wegsensor", "relativweg", "schwingweg", "weg_x")
    + ("x_position", "pos_x", "x_weg", "desplazamiento", "desplazamiento_relativo", "posicion", "posicion_x", "carrera")
    + ("deplacement", "deplacement_relatif", "debattement", "course", "spostamento", "posizione", "corsa")
    + ("deslocamento", "posicao", "位移", "相对位移", "displ", "extension", "y"),
    "force": ("tangential_force", "friction_force", "tangential", "friction", "force", "ft", "q", "fx", "load_cell")
    + ("reibkraft", "tangentialkraft", "querkraft", "reibungskraft", "kraft", "kraft_x", "f_t", "f_x")
    + ("lateral_force", "shear_force", "fuerza_tangencial", "fuerza_de_friccion", "fuerza_de_rozamiento")
    + ("fuerza_friccion", "fuerza", "fuerza_x", "force_tangentielle", "effort_tangentiel", "force_de_frottement")
    + ("force_frottement", "effort", "forza_tangenziale", "forza_di_attrito", "forza", "forca_tangencial")
    + ("forca_de_atrito", "forca", "摩擦力", "切向力", "切向载荷", "横向力", "力", "ff"),
    "normal load": ("normal_force", "normal_load", "fn", "p", "fz", "load")
    + ("normalkraft", "anpresskraft", "last", "kraft_z", "f_n", "f_z", "normallast", "fuerza_normal", "carga_normal")
    + ("carga", "force_normale", "charge_normale", "effort_normal", "charge", "forza_normale", "carico_normale")
    + ("carico", "forca_normal", "法向力", "法向载荷", "正压力", "载荷"),
    "time": ("time", "t", "elapsed_time", "zeit", "messzeit", "x_value", "timestamp", "uhrzeit", "zeitstempel")
    + ("tiempo", "hora", "temps", "heure", "tempo", "时间", "datetime", "date_time", "date/time", "horodatage"),
    "cycle": ("cycle", "cycles", "n", "cycle_number", "zyklus", "zyklen", "zyklusnummer", "lastspiel", "lastspiele")
    + ("cycle_count", "cycle_no", "lastwechsel", "ciclo", "ciclos", "numero_de_ciclos", "numero_de_ciclo", "cicli")
    + ("nombre_de_cycles", "numero_de_cycle", "循环", "循环次数", "循环数", "周期", "周次"),
    "repeat": ("repeat", "test", "specimen", "run", "wiederholung", "versuch", "prufling", "ensayo", "essai", "prova"),
    "x": ("x", "x_position", "pos_x", "position_x", "position", "distance", "strecke", "messstrecke", "lateral")
    + ("scan_position", "posicion_x", "distancia", "distanza", "abstand", "longueur", "longitud", "距离", "x坐标")
    + ("horizontal", "horz_dist", "posicion", "weg"),
    "y": ("y", "y_position", "pos_y", "position_y", "posicion_y", "y坐标"),
    "height": ("height", "z", "topography", "hoehe", "hohe", "z_position", "profile", "profil", "total_profile", "raw")
    + ("altura", "hauteur", "altezza", "perfil", "vertical", "gesamtprofil", "profil_total", "高度", "z坐标", "h"),
    "depth": ("depth", "wear_depth", "tiefe", "verschleisstiefe", "profundidad", "profondeur", "profondita", "深度")
    + ("磨损深度",),
    "displacement amplitude": ("displacement_amplitude", "amplitude", "wegamplitude", "verschiebungsamplitude")
    + ("amplitud_de_desplazamiento", "amplitude_de_deplacement", "ampiezza_di_spostamento"),
    "slip amplitude": ("slip_amplitude", "sliding_amplitude", "gleitamplitude", "schlupfamplitude")
    + ("amplitud_de_deslizamiento", "amplitude_de_glissement"),
    "largest force": ("max_tangential_force", "maximum_tangential_force", "tangential_force_max", "max_friction_force")
    + ("tangential_force_amplitude", "friction_force_amplitude", "q_max", "qmax", "f_max", "fmax", "ft_max")
    + ("max_force", "max_reibkraft", "maximale_reibkraft", "reibkraft_max", "maximale_tangentialkraft")
    + ("max_tangentialkraft", "fuerza_tangencial_maxima", "fuerza_tangencial_max", "fuerza_maxima")
    + ("force_tangentielle_maximale", "force_tangentielle_max", "forza_tangenziale_massima"),
    "energy": ("dissipated_energy", "friction_energy", "energy", "ed", "e_d", "dissipation", "dissipierte_energie")
    + ("reibenergie", "reibungsenergie", "verlustenergie", "energie", "energia_disipada", "energia")
    + ("energie_dissipee", "energia_dissipata", "energia_dissipada"),
}

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
)
_RATE = re.compile(r"_(?:default_sample_rate|standardmessrate)$")


def recognised(names: Sequence[str], channel: str) -> list[str]:
    """Columns of a channel's usual names, the most usual first; then those with a sensor or number beside the name."""
    known = units_of(channel)
    stems = [stem_and_unit(name, known)[0] for name in names]
    bare = ["" if stem in USUAL_NAMES[channel] else _alone(stem) for stem in stems]
    usual = USUAL_NAMES[channel]
    # Of two columns of one name, one is as likely as the other; times of several channels are alike.
    found = [
        names[stems.index(word)] for word in usual if stems.count(word) == 1 or (channel == "time" and word in stems)
    ]
    return found + [names[bare.index(word)] for word in usual if bare.count(word) == 1]


def _alone(stem: str) -> str:
    """``"ch_1_displacement"`` and ``"wegaufnehmer_1"`` as ``"displacement"`` and ``"weg"``."""
    words = [word.removesuffix("aufnehmer") for word in re.split(r"[_/]", _RATE.sub("", stem))]
    return "_".join(dict.fromkeys(word for word in words if word not in _BESIDE and not re.fullmatch(r"\W*\d*", word)))


def units_of(channel: str) -> dict[str, float]:
    """Units in which loggers write a channel, those per length of a line contact among them."""
    unit = UNIT_OF.get(channel, "")
    return FIELD_UNITS.get(unit, {}) | UNITS_PER_LENGTH.get(unit, {})


def stem_and_unit(name: str, known: dict[str, float]) -> tuple[str, str | None]:
    """``"Tangential force [N]"`` and ``"tangential_force_N"`` as ``("tangential_force", "N")``."""
    name = unicodedata.normalize("NFKC", name).lstrip("#%/; ")
    bracketed = re.fullmatch(r"(.+?)[\s_]*[\[(]\s*([^\[\]()]+?)\s*[\])]", name)
    match = bracketed or re.fullmatch(r"(.+?)[\s_/]*[_\[(\s/]\s*([^\s_\[\]()/]+)\s*[\])]?", name)
    told = usual_unit(match[2]) if match else ""
    stem, unit = (match[1], told) if match and told in known else (name, None)
    if unit is None and bracketed and usual_unit(bracketed[2]) in KNOWN_UNITS:
        stem = bracketed[1]
    stem = re.sub(r"[\s_.\-]+", "_", plain(stem).strip())
    return stem.removesuffix("_in") if unit else stem, unit
