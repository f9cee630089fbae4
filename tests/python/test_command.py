import subprocess
import sys

import jaculus


def run(*arguments, **options):
    return subprocess.run([sys.executable, "-m", "jaculus", *arguments], capture_output=True, text=True,
                          **options)


def test_the_command_is_of_the_same_version():
    assert run("--version").stdout.strip() == jaculus.__version__


def test_the_command_knows_what_ships_wherever_it_is_called(tmp_path):
    done = run("solve", "double_integrator", "--out", "plan", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "plan/plan.csv").is_file()


def test_the_command_ends_with_2_on_bad_input():
    done = run("solve", "no_such_problem")
    assert done.returncode == 2 and "allowed:" in done.stderr


def test_python_and_command_make_the_same_plan(leap, tmp_path):
    assert run("solve", "leap_tail", "--out", str(tmp_path / "command")).returncode == 0
    leap.save(tmp_path / "python")
    for file in ("plan.csv", "summary.json", "solution.json"):
        assert (tmp_path / "command" / file).read_bytes() == (tmp_path / "python" / file).read_bytes()
