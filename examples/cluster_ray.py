"""How wide a tail? Leaps for several widths on a cluster of Ray.

Here a cluster of this machine alone; `Pool(ray_address="auto")` is the one that this machine belongs
to. Takes a minute; needs `pip install ray`.
"""

# %% One leap
from ray.util.multiprocessing import Pool

import jaculus


def leap(width):
    plan = jaculus.solve("leap_tail", override={"tail.drag.width": width})
    return {"status": plan.status, "m/s^2": plan.figures["average_acceleration_m_s2"]}


# %% Many
widths = ["2 cm", "4 cm", "8 cm"]
with Pool(2) as pool:
    leaps = jaculus.map(leap, widths, executor=pool)
for width, result in zip(widths, leaps):
    print(f"{width}: {result['status']}, {result['m/s^2']:.3f} m/s^2")
# prints: 2 cm: optimal
# prints: 8 cm: optimal
