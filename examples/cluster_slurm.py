"""How wide a tail? Leaps for several widths, each a job of its own, by submitit.

    python cluster_slurm.py [slurm]

With `slurm` the jobs are an array of Slurm's, and the working directory is one that all machines share;
without, processes of this machine. Takes a minute; needs `pip install submitit`.
"""

# %% One leap
import sys

import submitit

import jaculus


def leap(width):
    plan = jaculus.solve("leap_tail", override={"tail.drag.width": width})
    return {"status": plan.status, "m/s^2": plan.figures["average_acceleration_m_s2"]}


# %% Many: an array of jobs, whose results come in order
widths = ["2 cm", "4 cm", "8 cm"]
if "slurm" in sys.argv[1:]:
    leaps = jaculus.map(leap, widths, executor="slurm", folder="jobs", timeout_min=30)
else:
    leaps = jaculus.map(leap, widths, executor=submitit.LocalExecutor("jobs"))
for width, result in zip(widths, leaps):
    print(f"{width}: {result['status']}, {result['m/s^2']:.3f} m/s^2")
# prints: 2 cm: optimal
# prints: 8 cm: optimal
