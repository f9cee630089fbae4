"""Runs the Python blocks of docs/python.md in order, in one namespace, and checks what they print."""
import contextlib
import importlib.util
import io
import pathlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
specification = importlib.util.spec_from_file_location("run_docs", ROOT / "tests/docs/run_docs.py")
docs = importlib.util.module_from_spec(specification)
specification.loader.exec_module(docs)


def write_odrive_bag(folder):
    """`my_bag`, that the page imports."""
    import bag_files
    status = {"pos_estimate": 0.0, "vel_estimate": 0.0, "torque_target": 0.0, "torque_estimate": 0.1,
              "iq_setpoint": 0.0, "iq_measured": 0.0, "active_errors": 0, "axis_state": 8, "procedure_result": 0,
              "trajectory_done_flag": False}
    bag_files.write_sqlite3(folder, [("/odrive_axis0/controller_status", "odrive_can/msg/ControllerStatus",
                                      bag_files.CONTROLLER_STATUS, {**status, "pos_estimate": 0.01 * k},
                                      bag_files.EPOCH + k * 10**6) for k in range(20)], definitions=True)


def test_every_block_runs_and_prints_what_it_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if importlib.util.find_spec("mcap_ros2"):
        write_odrive_bag(tmp_path / "my_bag")
    namespace, printed, count, passed_over = {}, "", 0, False
    for line, info, text in docs.blocks(ROOT / "docs/python.md"):
        needs = info.removeprefix("python needs ")
        if needs != info and importlib.util.find_spec(needs) is None:
            compile(text, f"docs/python.md:{line}", "exec")
            passed_over = True
        elif info == "python" or needs != info:
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                exec(compile(text, f"docs/python.md:{line}", "exec"), namespace)
            printed += out.getvalue()
            count += 1
        elif info == "text prints":
            for expected in () if passed_over else filter(str.strip, text.splitlines()):
                assert docs.occurs(expected, printed), f"{line}: {expected!r} is not in\n{printed}"
            printed, passed_over = "", False
        else:
            assert info.startswith("sh not run: "), f"{line}: a block is python, 'text prints' or not run"
    assert count >= 3
