"""Spoil a robot and find out how: a simulated pendulum with friction that its model has not.

Takes half a minute.
"""

# %% Trials of a pendulum whose joint has friction; the dataset looks as a robot's log would
import pathlib

import jaculus

trials = jaculus.simulate(
    "pendulum_trials", trials=4, seed=3, effects={"joint_viscous_friction": {"coefficient": 0.05}}
)
print(trials)
trials.plot("joints").savefig("spoiled_log.png")

# %% What is it?
diagnosis = jaculus.diagnose(trials, progress=print)
print(diagnosis.summary)
# prints: verdict: effect
(effect,) = diagnosis.effects
value = effect["parameters"]["coefficient"]
print(
    f"{effect['name']}: {value['value']:.4f} {value['unit']}, 95 % from {value['ci95'][0]:.4f} to {value['ci95'][1]:.4f}"
)
assert effect["name"] == "joint_viscous_friction"
assert value["ci95"][0] < 0.05 < value["ci95"][1]
diagnosis.plot().savefig("spoiled_ranking.png")

# %% The model with what was found added plays the experiment again
pathlib.Path("augmented.yaml").write_text(diagnosis.augmented)
again = jaculus.simulate("pendulum_trials", trials=1, seed=3, augmented="augmented.yaml")
print(again)
