"""Plans leaps of legged robots with drag tails, plays them, and diagnoses the gap to hardware.

    >>> import jaculus
    >>> plan = jaculus.solve("leap_tail")       # a problem that comes with jaculus, a file or a dict
    >>> print(plan.summary)
    >>> plan.plot()

Units are SI: m, kg, s, rad, N, N m, A, V. World frame: x forward, z up; pitch and every joint angle
turn about +y, so that positive pitch is nose-down. A planar leg stands for the left and the right
one: foot forces are sums over both, torques, currents and voltages those of one motor.

Bad input raises `InputError` (a `ValueError`) with file, line and key; a solve that does not converge
is a status of its plan. Ctrl-C raises `Interrupted` (a `KeyboardInterrupt`), which has the best so far.
"""
from ._core import __version__
from ._errors import InputError
from ._exports import JointTrajectory
from ._interrupts import Interrupted
from .datasets import Dataset, Stream, Trial, load_dataset, simulate
from .diagnoses import Diagnosis, diagnose
from .effects import Effect, EffectChecks, check_effect
from .executors import map
from .logs import import_bag, import_table
from .plans import Comparison, Plan, compare, solve
from .preflights import Preflight, preflight
from .robots import Problem, Robot, check_derivatives, load_problem, load_robot, shipped
from .studies import Study, study
from .terms import DerivativeCheck, Point, Row, Term

__all__ = [
    "Comparison", "Dataset", "DerivativeCheck", "Diagnosis", "Effect", "EffectChecks", "InputError",
    "Interrupted", "JointTrajectory", "Plan", "Point", "Preflight", "Problem", "Robot", "Row", "Stream",
    "Study", "Term", "Trial", "__version__", "check_derivatives", "check_effect", "compare", "diagnose",
    "import_bag", "import_table", "load_dataset", "load_problem", "load_robot", "map", "preflight",
    "shipped", "simulate", "solve", "study",
]
