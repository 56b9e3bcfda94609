"""Names of bones in a form in which patterns are searched."""

import re

_LONGEST = 200


def plain_name(name: str) -> str:
    """Return a name in lower case without its name space, with separators between its words."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", re.sub(r"^.*:", "", name)).lower()[:_LONGEST]
