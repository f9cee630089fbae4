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
from importlib import import_module as _import_module

from ._core import version as __version__

# Modules are imported when a name of theirs is asked for: a leap doesn't wait for what logs need.
_MODULES = {
    "_errors": ["InputError"],
    "_exports": ["JointTrajectory"],
    "_interrupts": ["Interrupted"],
    "datasets": ["Dataset", "Stream", "Trial", "load_dataset", "simulate"],
    "diagnoses": ["Diagnosis", "diagnose"],
    "effects": ["Effect", "EffectChecks", "check_effect"],
    "executors": ["map"],
    "logs": ["import_bag", "import_table"],
    "plans": ["Comparison", "Plan", "compare", "solve"],
    "preflights": ["Preflight", "preflight"],
    "robots": ["Problem", "Robot", "check_derivatives", "import_robot", "load_problem", "load_robot",
               "shipped"],
    "studies": ["Study", "study"],
    "terms": ["DerivativeCheck", "Point", "Row", "Term"],
}
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}

TYPE_CHECKING = False  # what checkers of types take for true; the module typing is slow to import
if TYPE_CHECKING:
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
    from .robots import (
        Problem, Robot, check_derivatives, import_robot, load_problem, load_robot, shipped)
    from .studies import Study, study
    from .terms import DerivativeCheck, Point, Row, Term

__all__ = [
    "Comparison", "Dataset", "DerivativeCheck", "Diagnosis", "Effect", "EffectChecks", "InputError",
    "Interrupted", "JointTrajectory", "Plan", "Point", "Preflight", "Problem", "Robot", "Row", "Stream",
    "Study", "Term", "Trial", "__version__", "check_derivatives", "check_effect", "compare", "diagnose",
    "import_bag", "import_robot", "import_table", "load_dataset", "load_problem", "load_robot", "map", "preflight",
    "shipped", "simulate", "solve", "study",
]


def __getattr__(name: str) -> object:
    if name in _MODULE_OF:
        value = getattr(_import_module(f".{_MODULE_OF[name]}", __name__), name)
        globals()[name] = value  # asked once
        return value
    if name in _MODULES:  # jaculus.plans, as after an import of it
        return _import_module(f".{name}", __name__)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list:
    return sorted({*globals(), *__all__})
