"""A plan in MuJoCo, by the names of the robot's own joints: played back, where does the robot end?

The robot is a 25 kg quadruped with a tail that air doesn't act on. What is played is torque and a weak
joint PD at 1 kHz, on a floor. Takes ten seconds; needs `pip install mujoco`.
"""

# %% A robot with a tail, and its leap
import math
import subprocess
import sys

import matplotlib.pyplot as plt
import mujoco
import numpy as np

import jaculus

command = [sys.executable, "-m", "jaculus"]
urdf = jaculus.load_robot("quadruped25").folder / "robot.urdf"
subprocess.run(
    [*command, "robot", "import", urdf, "--tail", "10 %", "--out", "tailed", "--replace"],
    check=True,
)
subprocess.run([*command, "robot", "urdf", "tailed", "--out", "tailed.urdf"], check=True)
plan = jaculus.solve("tailed/leap.yaml", override={"attach.tail.kind": "inertial"})
joints = plan.to_joints(rate=1000.0)

# %% The robot in MuJoCo: a free base, a floor, and feet where tailed/robot.yaml has them
RADIUS = 0.002  # of a foot [m]
spec = mujoco.MjSpec.from_file("tailed.urdf")
spec.compiler.fusestatic = False
spec.option.timestep = 1e-4
spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
base = spec.body("body")
base.add_freejoint()
ground = {"type": mujoco.mjtGeom.mjGEOM_PLANE, "size": [0, 0, 1]}
spec.worldbody.add_geom(name="floor", friction=[0.8, 0.005, 0.0001], solref=[0.002, 1], **ground)
for foot in ("front_left", "front_right", "rear_left", "rear_right"):
    spec.body(f"{foot}_shank").add_geom(
        name=foot,
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[RADIUS, 0, 0],
        pos=[0, 0, -0.22],
        mass=0,
        friction=[0.8, 0.005, 0.0001],
        solref=[0.002, 1],
    )
model = spec.compile()
data = mujoco.MjData(model)
at = [model.joint(name).qposadr[0] for name in joints.names]
dof = [model.joint(name).dofadr[0] for name in joints.names]

# %% The plan's first state, the feet on the floor
data.qpos[:3] = plan["x"][0], 0.0, plan["z"][0] + RADIUS
data.qpos[3:7] = math.cos(plan["pitch"][0] / 2), 0.0, math.sin(plan["pitch"][0] / 2), 0.0
data.qpos[at] = joints.position[0]

# %% Play it: torques, and a PD that makes a joint's largest torque at an error of 0.2 rad
kp = np.abs(joints.effort).max(axis=0) / 0.2
kd = 0.02 * kp
steps = round(1e-3 / model.opt.timestep)
played = []
for k in range(len(joints.time)):
    played.append([data.time, *data.qpos[[0, 2]], data.qvel[0]])
    for _ in range(steps):
        error = joints.position[k] - data.qpos[at]
        data.qfrc_applied[dof] = (
            joints.effort[k] + kp * error + kd * (joints.velocity[k] - data.qvel[dof])
        )
        if data.time < plan.time[-1]:
            mujoco.mj_step(model, data)

# %% Where it ends
w, x, y, z = data.qpos[3:7]
turned = math.degrees(math.atan2(2 * (w * y + x * z), 1 - 2 * (x * x + y * y)) - plan["pitch"][-1])
off = math.hypot(data.qpos[0] - plan["x"][-1], data.qpos[2] - RADIUS - plan["z"][-1])
print(f"{1e3 * off:.1f} mm and {abs(turned):.2f} deg from the plan's end, after {data.time:.4f} s")
print(f"forward speed {data.qvel[0]:.3f} m/s, planned {plan['x_velocity'][-1]:.3f}")
# prints: deg from the plan's end
assert off < 0.005 and abs(turned) < 1.0

# %% Planned, and played as dots
time, x, z, speed = np.array(played).T
figure, axis = plt.subplots(figsize=(7, 3.5), layout="constrained")
for planned, dots, label in (
    (plan["x"], x, "x [m]"),
    (plan["z"], z - RADIUS, "z [m]"),
    (plan["x_velocity"], speed, "x velocity [m/s]"),
):
    axis.plot(plan.time, planned, label=label)
    axis.plot(time[::3], dots[::3], "k.", markersize=3)
axis.set(xlabel="time [s]", title="base: plan, and MuJoCo's as dots")
axis.legend()
figure.savefig("plan_in_mujoco.png")
