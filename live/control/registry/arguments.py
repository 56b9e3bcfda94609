"""Arguments that several controls have."""

from live.control.registry.control import Argument

GROUP = Argument("group", "name", "the group's name in the patch; a single * is every group", default="*")
WHO = Argument(
    "group",
    "text",
    "who: a group, or groups, attributes, numbers and places as in `ember & left + 12-14`; * is all",
    default="*",
)
X = Argument("x", "float", "to the right as the audience sees it, from the centre of the stage", "m", -100, 100)
Z = Argument("z", "float", "towards the audience, from the centre of the stage", "m", -100, 100)
X2 = Argument("x2", "float", "the same of the second point", "m", -100, 100)
Z2 = Argument("z2", "float", "the same of the second point", "m", -100, 100)
STRENGTH = Argument("strength", "float", "how strongly it acts; 1 is the usual strength", "", 0, 10, 1.0)
MEASURES = Argument("measures", "float", "how long it acts", "measures", 0.25, 1024, 4.0)
NEXT = Argument("next", "bool", "1: from the next measure line on, 0: now", default=False)
POINTS = Argument("points", "text", "x z of one point after the other, as in `-3 0, 0 -2, 3 0`")
