"""How much drag? Leaps for several drag coefficients of the tail on a cluster of Dask.

Here a cluster of two processes on this machine; `Client("tcp://head:8786")` is one of yours, whose
machines have jaculus installed. Takes a minute; needs `pip install "dask[distributed]"`.
"""

# %% One leap
from distributed import Client

import jaculus


def leap(coefficient):
    plan = jaculus.solve("leap_tail", override={"tail.drag.coefficient": coefficient})
    return {"status": plan.status, "m/s^2": plan.figures["average_acceleration_m_s2"]}


# %% Many, one a worker at a time: the solver takes a process for itself
if __name__ == "__main__":
    coefficients = [1.0, 1.5, 2.0]
    with Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
        leaps = jaculus.map(leap, coefficients, executor=client)
    for coefficient, result in zip(coefficients, leaps):
        print(f"{coefficient}: {result['status']}, {result['m/s^2']:.3f} m/s^2")
# prints: 1.0: optimal
# prints: 2.0: optimal
