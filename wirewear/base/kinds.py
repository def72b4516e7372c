"""Names of the kinds of contact in studies, records and results, and of positions in a cycle."""

CROSSED_WIRES, LINE_CONTACT, BALL_ON_FLAT, POINT_CONTACT, JOINT = (
    "crossed-wires",
    "line-contact",
    "ball-on-flat",
    "point-contact",
    "joint",
)
CYLINDER_ON_FLAT = "cylinder-on-flat"  #: A line contact whose pad is a cylinder.

#: All that `kind` in a study may be, by the kind of contact.
NAMES = {
    CROSSED_WIRES: (CROSSED_WIRES,),
    LINE_CONTACT: (LINE_CONTACT, CYLINDER_ON_FLAT),
    BALL_ON_FLAT: (BALL_ON_FLAT,),
    POINT_CONTACT: (POINT_CONTACT,),
    JOINT: (JOINT,),
}
#: Contacts whose bodies wear a scar that is as wide as it is long.
AT_A_POINT = (CROSSED_WIRES, BALL_ON_FLAT, POINT_CONTACT)
#: Contacts of bodies, which wear.
OF_BODIES = (*AT_A_POINT, LINE_CONTACT)

#: Names of positions: mid-stroke and ends of the stroke, and just after the reversals there.
POSITIONS = ("mid-forward", "end-forward", "after-end-forward", "mid-back", "end-back", "after-end-back")
