"""A tail for a robot of yours: from its URDF to a leap with and without the tail.

    python tail_for_my_robot.py [ROBOT.urdf]

Without a file it takes a 25 kg quadruped that comes with jaculus. Takes a minute or two.
"""

# %% The robot's file
import pathlib
import subprocess
import sys

import jaculus

urdf = sys.argv[1] if len(sys.argv) > 1 else jaculus.load_robot("quadruped25").folder / "robot.urdf"

# %% Make a robot of it, with a tail of a tenth of its mass; all that is assumed is printed
done = subprocess.run(
    [
        sys.executable,
        "-m",
        "jaculus",
        "robot",
        "import",
        urdf,
        "--tail",
        "10 %",
        "--out",
        "my_robot",
    ],
    capture_output=True,
    text=True,
)
print(done.stdout, done.stderr)
assert done.returncode == 0
robot = jaculus.load_robot("my_robot")
print(f"{robot.mass:.1f} kg with its tail; coordinates: {', '.join(robot.coordinates)}")

# %% Its first leap, proposed with it, with the tail as a drag tail, as a mass alone, and without
leap = pathlib.Path("my_robot/leap.yaml")
plans = []
for kind in ("none", "inertial", "drag"):
    plans.append(jaculus.solve(leap, override={"attach.tail.kind": kind}))
    figures = plans[-1].figures
    print(f"{kind}: {plans[-1].status}, {figures['average_acceleration_m_s2']:.3f} m/s^2")
# prints: none: optimal
# prints: inertial: optimal
# prints: drag: optimal

# %% Side by side
comparison = jaculus.compare(plans)
comparison.plot("pitch").savefig("tail_for_my_robot.png")
print(comparison.to_pandas().T.to_string())
