"""A cause that no catalogue has: the diagnosis says what is missing, you write it down, it is found.

Takes half a minute. docs/tutorial_unknown.md explains the file of an effect.
"""

# %% An effect of your own: cogging, torque that repeats with the motor's angle
import pathlib

import jaculus

pathlib.Path("my_cogging.yaml").write_text("""\
format: jaculus-effect/1
name: my_cogging
caption: torque at the pendulum that repeats with its angle
at: {joint: pendulum}
parameters:
  sine: {unit: N m, nominal: 0, bounds: [-1, 1], scale: 0.1}
  cosine: {unit: N m, nominal: 0, bounds: [-1, 1], scale: 0.1}
torque: "sine * sin(7*q) + cosine * cos(7*q)"
""")

# %% A robot that has it, and a diagnosis that doesn't know it
trials = jaculus.simulate(
    "pendulum_trials",
    trials=4,
    seed=3,
    effects=["my_cogging:sine=0.25"],
    effect_files=["my_cogging.yaml"],
)
trials.plot("joints").savefig("unknown_cause_log.png")
quick = {"largest_model": 1, "kept_singles": 3}  # one effect at a time, for the sake of speed
without = jaculus.diagnose(trials, settings=quick)
print(without.summary)
# prints: verdict: unexplained
assert without.figures["remainder"]["established"]

# %% With it
found = jaculus.diagnose(trials, settings=quick, effect_files=["my_cogging.yaml"])
print(found.summary)
# prints: verdict: effect
assert found.effects[0]["name"] == "my_cogging"
