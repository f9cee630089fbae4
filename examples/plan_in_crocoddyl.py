"""A plan in Crocoddyl, by the names of the robot's own joints: as the start of a shooting problem.

The robot is a 25 kg quadruped with a tail that air doesn't act on, of which Crocoddyl knows nothing.
Takes ten seconds; needs `pip install crocoddyl pin==4.0.0`: the wheel of crocoddyl 3.2.1
was built with that Pinocchio, with 4.1.0 it crashes.
"""

# %% A robot with a tail, and its leap
import subprocess
import sys

import crocoddyl
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
joints = plan.to_joints()

# %% The robot in Crocoddyl: a floating base, a motor at every joint, feet as tailed/robot.yaml has them
model = pin.buildModelFromUrdf("tailed.urdf", pin.JointModelFreeFlyer())
feet = {"front_foot": [], "rear_foot": []}
for foot, frames in feet.items():
    for side in ("left", "right"):
        shank = model.getJointId(f"{foot.split('_')[0]}_{side}_knee")
        place = pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.22]))
        frames.append(model.addFrame(pin.Frame(f"{foot}_{side}", shank, place, pin.OP_FRAME)))
state = crocoddyl.StateMultibody(model)
actuation = crocoddyl.ActuationModelFloatingBase(state)


def shooting_node(phase, step):
    """One step with the feet of a phase of the plan on the floor."""
    contacts = crocoddyl.ContactModelMultiple(state, actuation.nu)
    for frame in feet["rear_foot"] + (feet["front_foot"] if phase == "all_feet" else []):
        contact = crocoddyl.ContactModel3D(
            state, frame, np.zeros(3), pin.LOCAL_WORLD_ALIGNED, actuation.nu, np.zeros(2)
        )
        contacts.addContact(model.frames[frame].name, contact)
    costs = crocoddyl.CostModelSum(state, actuation.nu)
    torque = crocoddyl.ResidualModelControl(state, actuation.nu)
    costs.addCost("torque", crocoddyl.CostModelResidual(state, torque), 1e-3)
    dynamics = crocoddyl.DifferentialActionModelContactFwdDynamics(
        state, actuation, contacts, costs, 1e-9, True
    )
    return crocoddyl.IntegratedActionModelRK(dynamics, crocoddyl.RKType.four, step)


# %% States and torques of the plan, in the order of the model's joints
def state_of(k):
    q, v = pin.neutral(model), np.zeros(model.nv)
    R = pin.rpy.rpyToMatrix(0.0, plan["pitch"][k], 0.0)
    q[:3], q[3:7] = (plan["x"][k], 0.0, plan["z"][k]), pin.Quaternion(R).coeffs()
    v[:3] = R.T @ [plan["x_velocity"][k], 0.0, plan["z_velocity"][k]]
    v[4] = plan["pitch_velocity"][k]
    for name, (joint, sign) in joints.planned.items():
        at = model.joints[model.getJointId(name)]
        q[at.idx_q], v[at.idx_v] = sign * plan[joint][k], sign * plan[f"{joint}_velocity"][k]
    return np.concatenate([q, v])


def torques_of(k):
    u = np.zeros(actuation.nu)
    for name, (joint, sign) in joints.planned.items():
        u[model.joints[model.getJointId(name)].idx_v - 6] = sign * plan[f"{joint}_torque"][k]
    return u


# %% Crocoddyl's contact dynamics beside the plan: forces of the floor at every sample
normal = {foot: np.zeros(len(plan.time)) for foot in feet}
for k, phase in enumerate(plan.phase):
    dynamics = shooting_node(phase, 1e-3).differential
    data = dynamics.createData()
    dynamics.calc(data, state_of(k), torques_of(k))
    for foot, frames in feet.items():
        if foot == "rear_foot" or phase == "all_feet":
            contacts = [data.multibody.contacts.contacts[model.frames[f].name] for f in frames]
            normal[foot][k] = sum(contact.f.linear[2] for contact in contacts)
worst = max(np.abs(normal[foot] - plan[f"{foot}_force_z"]).max() for foot in feet)
print(f"normal forces differ by at most {worst:.0e} N of {normal['rear_foot'].max():.0f} N")
assert worst < 0.01

figure, axis = plt.subplots(figsize=(7, 3.5), layout="constrained")
for foot in feet:
    axis.plot(plan.time, plan[f"{foot}_force_z"], label=foot)
    axis.plot(plan.time[::2], normal[foot][::2], "k.", markersize=3)
axis.set(xlabel="time [s]", ylabel="normal force [N]", title="plan, and Crocoddyl's as dots")
axis.legend()
figure.savefig("plan_in_crocoddyl.png")

# %% As a shooting problem: what one step from each sample misses the next one by, torques held
ahead = np.flatnonzero(np.diff(plan.time) > 0)  # the border of two phases stands twice
nodes = [shooting_node(plan.phase[k], plan.time[k + 1] - plan.time[k]) for k in ahead]
states, torques = (
    [state_of(k) for k in ahead],
    [0.5 * (torques_of(k) + torques_of(k + 1)) for k in ahead],
)
problem = crocoddyl.ShootingProblem(states[0], nodes[:-1], nodes[-1])
problem.calc(states, torques[:-1])
gaps = [state.diff(after, data.xnext) for data, after in zip(problem.runningDatas, states[1:])]
largest = np.abs(gaps)[:, : model.nv].max()
print(f"{problem.T} steps, the largest gap is {largest:.1e} m or rad")
assert largest < 1e-3
# prints: steps, the largest gap is
