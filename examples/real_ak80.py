"""A real robot: the AK80-6 pendulum of DFKI's torque_limited_simple_pendulum, from its published log.

    python real_ak80.py DATASET

DATASET is a folder with dataset.yaml and its robot: JACULUS_DATA/pendulum/ak80. Takes two minutes.
"""

# %% The log
import os
import sys

import jaculus

given = [folder for folder in sys.argv[1:] if os.path.isdir(folder)]  # not a notebook's kernel's
dataset = jaculus.load_dataset(
    given[0] if given else os.path.join(os.environ["JACULUS_DATA"], "pendulum/ak80")
)
print(dataset.summary)
print(dataset.provenance)
dataset.plot("joints").savefig("real_ak80_log.png")

# %% What does its model lack?
# A ROS 2 bag of this log gives the same answer.
diagnosis = jaculus.diagnose(dataset)
print(diagnosis.summary)
# prints: joint_coulomb_friction
diagnosis.plot().savefig("real_ak80.png")
assert diagnosis.gap["after"] < 0.3 * diagnosis.gap["before"]
