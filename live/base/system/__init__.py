"""All that differs between Linux, macOS and Windows: processes, sockets, shared memory, signals, locks.

`features.py` says which way is taken; every other module here has a way for Linux and one that works everywhere. No
other module may name a function that some system lacks (`tests/base/system/test_portability.py`), but for the modules
that do their work on Linux alone, which that test lists.
"""
