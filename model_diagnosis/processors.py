"""How many threads a diagnosis may use."""

import os


def threads_here() -> int:
    """Threads that share the work: as ``OMP_NUM_THREADS`` says, else one for each processor this process may run on.

    Where several diagnoses run beside each other, each is faster with one.
    """
    wanted = os.environ.get("OMP_NUM_THREADS", "")
    return int(wanted) if wanted.isdecimal() and int(wanted) > 0 else len(os.sched_getaffinity(0))
