"""Figures 3 to 6 of Norby et al. 2021, computed, beside what the paper prints.

Takes ten seconds. Figure 5's points are made up after the paper's fit, for its measurements are not
published; figures 1, 2, 7 and 8 are photographs and a sketch, 9 is measured (first_leap.py plans it).
"""

# %% Studies that come with jaculus
import matplotlib.pyplot as plt
import numpy as np

import jaculus

studies = {
    name: jaculus.study(name, out=f"study_{name}", jobs=2)
    for name in ("fig3_effectiveness", "fig4_shaft", "drag_bench", "fig6_drop")
}
for name, study in studies.items():
    assert study.complete
    print(study.summary)
# prints: drag moment left at L0/L = 0.6
tables = {name: study.to_pandas() for name, study in studies.items()}

# %% Fig. 3: effectiveness of the tail over its inertia, with drag and (dotted) without
figure, axes = plt.subplots(2, 2, figsize=(8, 6), layout="constrained")
for length, rows in tables["fig3_effectiveness"].groupby("tail_length_m"):
    axes[0, 0].plot(rows["normalised_inertia"], rows["effectiveness"], label=f"{length} m")
axes[0, 0].plot(
    rows["normalised_inertia"], rows["effectiveness_without_drag"], "k:", label="no drag"
)
axes[0, 0].set(title="Fig. 3", xlabel="normalised inertia [-]", ylabel="effectiveness [-]")
axes[0, 0].legend()

# %% Fig. 4: drag moment that is left where a part of the tail is shaft
rows = tables["fig4_shaft"]
axes[0, 1].plot(rows["shaft_ratio"], rows["shaft_torque_ratio"])
axes[0, 1].set(title="Fig. 4", xlabel="shaft over length [-]", ylabel="moment, relative [-]")

# %% Fig. 5: drag moment over the tail's speed, as fitted here and as the paper has it
speed = np.linspace(0.0, 30.0)
fit = tables["drag_bench"].loc[lambda rows: rows["taken"] == "yes"].iloc[0]
axes[1, 0].plot(speed, fit["quadratic_N_m_s2"] * speed**2, label="fitted")
axes[1, 0].plot(speed, 0.00514 * speed**2, "k:", label="paper")
axes[1, 0].set(title="Fig. 5", xlabel="speed [rad/s]", ylabel="moment [N m]")
axes[1, 0].legend()
print(f"Fig. 5: {fit['quadratic_N_m_s2']:.5f} N m s^2, paper 0.00514")
# prints: Fig. 5: 0.00519 N m s^2, paper 0.00514

# %% Fig. 6: pitch of the body in one body length of fall
for case, rows in tables["fig6_drop"].groupby("case"):
    axes[1, 1].plot(rows["time_s"], rows["body_angle_deg"], label=case)
axes[1, 1].set(title="Fig. 6", xlabel="time [s]", ylabel="pitch of the body [deg]")
axes[1, 1].legend()
figure.savefig("paper_figures.png", dpi=90)
