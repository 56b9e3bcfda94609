"""Paths for tests: the checkout, and the folder of shared data beside it, which may be absent."""

from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[1]
"""The checkout."""
SHARED: Final = ROOT.parent / "shared"
"""Recordings, songs and papers; tests that need them skip without them."""
