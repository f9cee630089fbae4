"""A first leap: with a drag tail, without a tail, and what the tail is worth.

Run it anywhere where `pip install` of jaculus and matplotlib was done; cells (# %%) open as a notebook in
VS Code, PyCharm, Spyder and Jupyter (jupytext). Takes a quarter of a minute.
"""

# %% Solve a problem that comes with jaculus
import jaculus

plan = jaculus.solve("leap_tail")
print(plan.summary)
# prints: status optimal
# prints: verification: passed

# %% What is in it: arrays by name, SI units
print(
    "liftoff at",
    round(plan.figures["liftoff_velocity_m_s"], 2),
    "m/s after",
    round(plan.time[-1], 3),
    "s",
)
print("columns:", ", ".join(plan.columns[:8]))
plan.plot().savefig("first_leap.png")

# %% The same leap without a tail
tailless = jaculus.solve("leap_tailless")
comparison = jaculus.compare([tailless, plan])
print(comparison.summary)
# prints: leap_tailless
figure = comparison.plot("x_velocity")
figure.savefig("first_leap_comparison.png")
gain = (
    plan.figures["average_acceleration_m_s2"] / tailless.figures["average_acceleration_m_s2"] - 1.0
)
assert gain > 0.0, "the tail should help"
print(f"the tail adds {100 * gain:.0f} % of mean acceleration")

# %% For a robot: torques of its own joints, as a file for ROS where rosbags is installed
try:
    print("written:", plan.to_bag("first_leap.mcap", rate=500))
except ImportError as missing:
    print(missing)
