"""How much drag? Leaps for several drag coefficients of the tail on a cluster of Ray.

Here a cluster of this machine alone; `Pool(ray_address="auto")` is the one that this machine belongs
to. Takes a minute; needs `pip install ray`.
"""

# %% One leap
from ray.util.multiprocessing import Pool

import jaculus


def leap(coefficient):
    plan = jaculus.solve("leap_tail", override={"tail.drag.coefficient": coefficient})
    return {"status": plan.status, "m/s^2": plan.figures["average_acceleration_m_s2"]}


# %% Many
coefficients = [1.0, 1.5, 2.0]
with Pool(2) as pool:
    leaps = jaculus.map(leap, coefficients, executor=pool)
for coefficient, result in zip(coefficients, leaps):
    print(f"{coefficient}: {result['status']}, {result['m/s^2']:.3f} m/s^2")
# prints: 1.0: optimal
# prints: 2.0: optimal
