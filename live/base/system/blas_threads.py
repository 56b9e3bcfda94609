"""Number of threads of the linear algebra behind numpy."""

import os
from typing import Final

VARIABLES: Final = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""What OpenBLAS, OpenMP, MKL and Accelerate read when numpy is imported first."""


def use_one_blas_thread() -> None:
    """Let numpy multiply and solve in one thread, unless the user says otherwise. Call it before numpy is imported.

    For matrices of some hundred rows more threads gain little, and on a busy machine they wait for each other by
    spinning: learning took 16 times as long. One thread also gives the same bits whatever the number of cores.
    """
    for name in VARIABLES:
        os.environ.setdefault(name, "1")
