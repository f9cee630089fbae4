"""A real robot: six leaps of Minitaur with its drag tail, by motion capture, beside the authors' plan.

    python real_minitaur.py [DATASET]

DATASET is a folder with dataset.yaml: JACULUS_DATA/minitaur/leap_tail_2019-06-21. Takes a minute of two
cores, nearly all of it in simulated leaps; effects are tried one at a time here, and docs/results has
what a whole diagnosis of all sets says.
"""

# %% The log
import os
import sys

import jaculus

given = [folder for folder in sys.argv[1:] if os.path.isdir(folder)]  # not a notebook's kernel's
dataset = jaculus.load_dataset(
    given[0] if given else os.path.join(os.environ["JACULUS_DATA"], "minitaur/leap_tail_2019-06-21")
)
print(dataset.summary)
print(dataset.provenance)
dataset.plot("mocap").savefig("real_minitaur_log.png")

# %% What does its model lack? Friction in the legs, of single effects, and not that alone
diagnosis = jaculus.diagnose(dataset, settings={"largest_model": 1, "kept_singles": 3})
print(diagnosis.summary)
# prints: verdict: partial
diagnosis.plot().savefig("real_minitaur.png")
assert diagnosis.gap["after"] < 0.8 * diagnosis.gap["before"]
