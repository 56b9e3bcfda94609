"""Counts of rejected OSC messages of operators."""

from collections import Counter
from types import SimpleNamespace
from typing import Any, cast

from live.app.services.osc_services import rejected_counts


def test_rejected_counts_include_lost_messages() -> None:
    osc = SimpleNamespace(refused=lambda: {"range": 2}, lost=3)
    assert rejected_counts(cast(Any, osc)) == Counter({"range": 2, "lost before it was read": 3})
