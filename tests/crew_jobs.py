"""Work for processes of their own, which they import by name."""

import os
import time


def odd_one_out(job):
    """Ten times the number; a negative one is refused, and 13 takes its process along."""
    if job < 0:
        raise ValueError(f"{job} is negative")
    if job == 13:
        os._exit(3)
    return 10 * job


def pause(seconds):
    """Sleep, and say how long."""
    time.sleep(seconds)
    return seconds


def threads(_job):
    """How many threads the numbers may take."""
    return os.environ.get("OMP_NUM_THREADS")
