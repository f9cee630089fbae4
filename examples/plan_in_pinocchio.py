"""A plan in Pinocchio, by the names of the robot's own joints: does its inverse dynamics agree?

The robot is a 25 kg quadruped with a tail that air doesn't act on, of which Pinocchio knows nothing.
Takes ten seconds; needs `pip install pin`.
"""

# %% A robot with a tail, and its leap
import subprocess
import sys

import matplotlib.pyplot as plt
import numpy as np
import pinocchio as pin

import jaculus

command = [sys.executable, "-m", "jaculus"]
urdf = jaculus.load_robot("quadruped25").folder / "robot.urdf"
subprocess.run(
    [*command, "robot", "import", urdf, "--tail", "10 %", "--out", "tailed", "--replace"],
    check=True,
)
subprocess.run([*command, "robot", "urdf", "tailed", "--out", "tailed.urdf"], check=True)
plan = jaculus.solve("tailed/leap.yaml", override={"attach.tail.kind": "inertial"})
print(plan.status, "in", round(plan.time[-1], 4), "s")
# prints: optimal in

# %% The same robot in Pinocchio; joints are found by name, feet are those of tailed/robot.yaml
model = pin.buildModelFromUrdf("tailed.urdf", pin.JointModelFreeFlyer())
data = model.createData()
joints = plan.to_joints()
assert set(joints.planned) == set(model.names[2:])
shanks = {
    foot: [model.getJointId(f"{foot}_{side}_knee") for side in ("left", "right")]
    for foot in ("front", "rear")
}
at_foot = pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.22]))


# %% Coordinates, velocities and accelerations of a sample: x, z and pitch of the base, then joints
def sample(k):
    q, v, a = pin.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
    pitch, rate = plan["pitch"][k], np.array([0.0, plan["pitch_velocity"][k], 0.0])
    R = pin.rpy.rpyToMatrix(0.0, pitch, 0.0)
    q[:3] = plan["x"][k], 0.0, plan["z"][k]
    q[3:7] = pin.Quaternion(R).coeffs()
    v[:3] = R.T @ [plan["x_velocity"][k], 0.0, plan["z_velocity"][k]]
    v[3:6] = rate
    a[:3] = R.T @ [plan["x_acceleration"][k], 0.0, plan["z_acceleration"][k]] - np.cross(
        rate, v[:3]
    )
    a[4] = plan["pitch_acceleration"][k]
    for name, (joint, sign) in joints.planned.items():
        at = model.joints[model.getJointId(name)]
        q[at.idx_q] = sign * plan[joint][k]
        v[at.idx_v] = sign * plan[f"{joint}_velocity"][k]
        a[at.idx_v] = sign * plan[f"{joint}_acceleration"][k]
    return q, v, a


def floor_forces(k, q):
    """Generalised forces of the floor; the plan's are of the left and the right foot together."""
    total = np.zeros(model.nv)
    pin.computeJointJacobians(model, data, q)
    pin.framesForwardKinematics(model, data, q)
    for foot, ids in shanks.items():
        force = 0.5 * np.array(
            [plan[f"{foot}_foot_force_x"][k], 0, plan[f"{foot}_foot_force_z"][k]]
        )
        for joint in ids:
            J = pin.getJointJacobian(model, data, joint, pin.LOCAL_WORLD_ALIGNED)
            arm = data.oMi[joint].rotation @ at_foot.translation
            total += J[:3].T @ force + J[3:].T @ np.cross(arm, force)
    return total


# %% Inverse dynamics: nothing is left for the base, the rest is the plan's torques
left, torques = [], []
for k in range(len(plan.time)):
    q, v, a = sample(k)
    tau = pin.rnea(model, data, q, v, a) - floor_forces(k, q)
    left.append(np.abs(tau[:6]).max())
    torques.append([tau[model.joints[model.getJointId(name)].idx_v] for name in joints.planned])
planned = np.array([sign * plan[f"{joint}_torque"] for joint, sign in joints.planned.values()]).T
off = np.abs(torques - planned).max()
print(f"left for the base at most {max(left):.0e} N, N m; torques differ by at most {off:.0e} N m")
assert max(left) < 1e-6 and off < 1e-6
# prints: left for the base at most

# %% Side by side
figure, axis = plt.subplots(figsize=(7, 3.5), layout="constrained")
for number, name in enumerate(joints.planned):
    if "right" not in name:
        axis.plot(plan.time, planned[:, number], label=name)
        axis.plot(plan.time[::3], np.array(torques)[::3, number], "k.", markersize=3)
axis.set(xlabel="time [s]", ylabel="torque [N m]", title="plan, and Pinocchio's as dots")
axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
figure.savefig("plan_in_pinocchio.png")
