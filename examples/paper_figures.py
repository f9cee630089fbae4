"""Figures 3 to 6 of Norby et al. 2021, computed, beside what the paper prints.

Takes a minute or two.
"""

# %% Studies that come with jaculus
import jaculus

studies = {
    name: jaculus.study(name, out=f"study_{name}", jobs=2)
    for name in ("fig3_effectiveness", "fig4_shaft", "drag_bench", "fig6_drop")
}
for name, study in studies.items():
    assert study.complete
    print(study.summary)

# %% Fig. 3: effectiveness over the tail's length
figure3 = studies["fig3_effectiveness"]
print(figure3.to_pandas().describe().T.to_string())
figure3.plot("tail_length_m", "effectiveness", by="normalised_inertia").savefig("figure3.png")
