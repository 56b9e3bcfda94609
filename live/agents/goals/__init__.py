"""Goals of their own: each agent goes to a place, or to several in turn, and stops there (T082 arrive, T105)."""
