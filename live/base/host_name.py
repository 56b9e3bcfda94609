"""Host names as people write them: of a machine that is reached by more than its address."""

from typing import Final

HOST_NAME: Final = r"^[A-Za-z0-9]([A-Za-z0-9.-]{0,190}[A-Za-z0-9])?(:[0-9]{1,5})?$"
"""NAME or NAME:PORT, as in `show.example` or `show.example:443`; a regular expression."""
