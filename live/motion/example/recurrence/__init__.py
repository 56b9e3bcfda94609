"""The recurrence (6)-(8)."""
