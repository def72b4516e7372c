"""Names of the kinds of contact in studies, records and results."""

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
