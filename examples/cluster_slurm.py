"""How much drag? Leaps for several drag coefficients of the tail, each a job of its own, by submitit.

    python cluster_slurm.py [slurm]

With `slurm` the jobs are an array of Slurm's, and the working directory is one that all machines share;
without, processes of this machine. Takes a minute; needs `pip install submitit`.
"""

# %% One leap
import sys

import submitit

import jaculus


def leap(coefficient):
    plan = jaculus.solve("leap_tail", override={"tail.drag.coefficient": coefficient})
    return {"status": plan.status, "m/s^2": plan.figures["average_acceleration_m_s2"]}


# %% Many: an array of jobs, whose results come in order
coefficients = [1.0, 1.5, 2.0]
if "slurm" in sys.argv[1:]:
    leaps = jaculus.map(leap, coefficients, executor="slurm", folder="jobs", timeout_min=30)
else:
    leaps = jaculus.map(leap, coefficients, executor=submitit.LocalExecutor("jobs"))
for coefficient, result in zip(coefficients, leaps):
    print(f"{coefficient}: {result['status']}, {result['m/s^2']:.3f} m/s^2")
# prints: 1.0: optimal
# prints: 2.0: optimal
