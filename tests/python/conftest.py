import os

import pytest

import jaculus

os.environ.setdefault("MPLBACKEND", "Agg")


@pytest.fixture(scope="session")
def leap():
    """The leap with drag tail, solved once."""
    return jaculus.solve("leap_tail")


@pytest.fixture(scope="session")
def pendulum_trials():
    """A pendulum with friction that its model has not."""
    return jaculus.simulate("pendulum_trials", trials=2, seed=3,
                            effects={"joint_viscous_friction": {"coefficient": 0.05}})
