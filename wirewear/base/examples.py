"""Studies and records that come with the program, which commands take by their names."""

from pathlib import Path

STUDIES = ("steel_wires", "ball_on_flat", "cylinder_on_flat")
RECORDS = ("no_gap", "free_play_rig", "rigid_stated_compliant_rig")

_HERE = Path(__file__).resolve()
#: Where they are: `setup.py` puts them beside the installed modules; a checkout has them among its studies.
_FOLDERS = (_HERE.parents[1] / "examples", _HERE.parents[2] / "studies")


def example(name: str) -> Path | None:
    """The file of the study, or the folder of the record, of that name; None where there is none."""
    inner = {one: f"{one}/study.toml" for one in STUDIES}
    inner |= {one: f"steel_wires/example_records/{one}" for one in RECORDS}
    places = (folder / inner[name] for folder in _FOLDERS if name in inner)
    return next((place for place in places if place.exists()), None)
