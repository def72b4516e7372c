"""Published tribometers: how much of the applied displacement the contact's and the rig's compliance explain."""

from wirewear.tribometers.bodies import ASSUMED, Bodies, line_contact_stiffness
from wirewear.tribometers.printing import tribometers_json, tribometers_table, verdicts_table
from wirewear.tribometers.report import Tribometer, hertz_length, judge, judged, read_tribometers
from wirewear.tribometers.rows import CONTACTS, NUMBERS, TribometerRow, read_rows

__all__ = [
    "ASSUMED",
    "CONTACTS",
    "NUMBERS",
    "Bodies",
    "Tribometer",
    "TribometerRow",
    "hertz_length",
    "judge",
    "judged",
    "line_contact_stiffness",
    "read_rows",
    "read_tribometers",
    "tribometers_json",
    "tribometers_table",
    "verdicts_table",
]
