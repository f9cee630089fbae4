"""What a leap costs from Python over the command line; ends with 1 where that is 5 % or more.

Both solve leap_tail and write its files, each in a process of its own, in turns; Python's start-up and its
imports count. Medians of processor time are compared, which other programs on the machine hardly move; wall
time is printed beside it.
"""
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time

from jaculus._command import program

ROUNDS = int(os.environ.get("ROUNDS", "15"))
MOST = 1.05
CODE = "import sys, jaculus; jaculus.solve('leap_tail').save(sys.argv[1])"


def used(command):
    """Wall and processor time of a process [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.perf_counter()
    subprocess.run(command, check=True)
    wall = time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    command, package = [], []
    with tempfile.TemporaryDirectory() as out:
        for _ in range(ROUNDS):
            command.append(used([program(), "solve", "leap_tail", "--quiet", "--out", out]))
            package.append(used([sys.executable, "-c", CODE, out]))
    for k, what in enumerate(("wall time", "processor time")):
        by = [statistics.median(times[k] for times in runs) for runs in (command, package)]
        ratio = by[1] / by[0]
        print(f"leap_tail, {what}, medians of {ROUNDS}: command {by[0]:.3f} s, Python {by[1]:.3f} s, "
              f"ratio {ratio:.3f}")
    sys.exit(0 if ratio < MOST else 1)


main()
