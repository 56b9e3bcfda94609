"""The audience's gateway: a process of its own to which phones talk, and what it makes of their voices."""
