"""A tail for a robot of yours: from its URDF to a leap with and without the tail.

    python tail_for_my_robot.py [ROBOT.urdf]

Without a file it takes a 25 kg quadruped that comes with jaculus. Takes a minute or two.
"""

# %% The robot's file
import sys

import jaculus

urdf = jaculus.load_robot("quadruped25").folder / "robot.urdf"
for given in sys.argv[1:]:
    if given.endswith((".urdf", ".xml")):  # a notebook's kernel has arguments of its own
        urdf = given

# %% Make a robot of it, with a tail of a tenth of its mass; read what is assumed
robot = jaculus.import_robot(urdf, "my_robot", tail="10 %", replace=True)
for what in ("decided", "assumed", "to_fill_in"):
    print(f"{what.replace('_', ' ')}:", *robot.imported[what], sep="\n  ")
print(f"{robot.mass:.1f} kg with its tail; coordinates: {', '.join(robot.coordinates)}")

# %% Its first leap, proposed with it, with the tail as a drag tail, as a mass alone, and without
leap = {"format": "jaculus-problem/1", "extends": "my_robot/leap.yaml", "robot": "my_robot"}
plans = []
for kind in ("none", "inertial", "drag"):
    plans.append(jaculus.solve({**leap, "name": kind, "override": {"attach.tail.kind": kind}}))
    figures = plans[-1].figures
    print(f"{kind}: {plans[-1].status}, {figures['average_acceleration_m_s2']:.3f} m/s^2")
# prints: none: optimal
# prints: inertial: optimal
# prints: drag: optimal

# %% Side by side
comparison = jaculus.compare(plans)
comparison.plot("x_velocity").savefig("tail_for_my_robot.png")
print(comparison.to_pandas().T.to_string())
comparison.save("leaps_of_my_robot")  # report.html there has charts and an animation
