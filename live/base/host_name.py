"""Pattern of host names that users may enter."""

from typing import Final

HOST_NAME_PATTERN: Final = r"^[A-Za-z0-9]([A-Za-z0-9.-]{0,190}[A-Za-z0-9])?(:[0-9]{1,5})?$"
"""Regular expression for NAME or NAME:PORT, as in `show.example` or `show.example:443`."""
