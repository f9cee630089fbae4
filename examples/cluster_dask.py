"""How wide a tail? Leaps for several widths on a cluster of Dask.

Here a cluster of two processes on this machine; `Client("tcp://head:8786")` is one of yours, whose
machines have jaculus installed. Takes a minute; needs `pip install "dask[distributed]"`.
"""

# %% One leap
from distributed import Client

import jaculus


def leap(width):
    plan = jaculus.solve("leap_tail", override={"tail.drag.width": width})
    return {"status": plan.status, "m/s^2": plan.figures["average_acceleration_m_s2"]}


# %% Many, one a worker at a time: the solver takes a process for itself
if __name__ == "__main__":
    widths = ["2 cm", "4 cm", "8 cm"]
    with Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
        leaps = jaculus.map(leap, widths, executor=client)
    for width, result in zip(widths, leaps):
        print(f"{width}: {result['status']}, {result['m/s^2']:.3f} m/s^2")
# prints: 2 cm: optimal
# prints: 8 cm: optimal
