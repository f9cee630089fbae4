"""What an import leaves out and refuses; the command; a diagnosis from bags."""

import os
import pathlib
import subprocess
import sys

import pytest

import jaculus

pytest.importorskip("rosbags", reason="bags need rosbags")
pytest.importorskip("mcap_ros2", reason="tests of bags need mcap-ros2-support")
import bag_files  # noqa: E402
from bag_files import (
    EPOCH,
    MEASURED,
    PENDULUM,
    ROWS,
    TIMES,
    has,
    mcap,
    odrive,
)  # noqa: E402

SHARED = pathlib.Path(os.environ.get("JACULUS_DATA", "../shared/data")).resolve()


# What is left out, and faults


def test_topics_that_are_not_taken_are_named(tmp_path):
    bag = mcap(tmp_path, [*bag_files.joint_states(ROWS, "pendulum"), *map(odrive, TIMES)])
    dataset = jaculus.import_bag(bag, tmp_path / "out", **PENDULUM)
    assert has(
        dataset,
        "topics left out: /odrive_axis0/controller_status (odrive_can/msg/ControllerStatus, 60 mess",
    )


@pytest.mark.parametrize(
    "topics, told",
    [
        ({"/joint_stats": {}}, "no topic '/joint_stats', did you mean '/joint_states'"),
        ({"/odrive_axis0/controller_status": {}}, "allowed: `channels` in the map"),
        (
            {
                "/odrive_axis0/controller_status": {
                    "channels": {"pendulum": {"field": "pos_estimat", "unit": "rev"}}
                }
            },
            "no 'pos_estimat', did you mean 'pos_estimate'",
        ),
        (
            {
                "/odrive_axis0/controller_status": {
                    "channels": {"pendulum": {"field": "pos_estimate", "unit": "V m"}}
                }
            },
            "dict:.*pendulum",
        ),
        (
            {"/joint_states": {"stream": "a"}, "/odrive_axis0/controller_status": {"stream": "a"}},
            "another topic has it",
        ),
        (
            {"/joint_states": {"channels": {"pendulum": {"field": "position[9]", "unit": "rad"}}}},
            r"\[9\] of 1 entries",
        ),
        (
            {"/joint_states": {"channels": {"pendulum": {"field": "header", "unit": "rad"}}}},
            "'header' is no number",
        ),
        ({"/joint_states": {"chanels": {}}}, "chanels.*did you mean|did you mean.*channels"),
    ],
)
def test_faults_of_a_map_are_named_with_what_is_allowed(tmp_path, topics, told):
    bag = mcap(tmp_path, [*bag_files.joint_states(ROWS, "pendulum"), *map(odrive, TIMES)])
    with pytest.raises(jaculus.InputError, match=told):
        jaculus.import_bag(
            bag, tmp_path / "out", columns={"format": "jaculus-bag/1", "topics": topics}, **PENDULUM
        )


def test_a_file_that_is_no_bag_is_refused(tmp_path):
    (tmp_path / "no.mcap").write_text("no bag")
    for given in ("no.mcap", "absent.mcap"):
        with pytest.raises(jaculus.InputError, match=f"{given}.*") as caught:
            jaculus.import_bag(tmp_path / given, tmp_path / "out", **PENDULUM)
        assert caught.value.file == str(tmp_path / given)


def test_a_bag_that_was_cut_off_or_has_foreign_messages_says_what_to_do(tmp_path):
    whole = mcap(tmp_path, bag_files.joint_states(ROWS, "pendulum"))
    (tmp_path / "cut.mcap").write_bytes(whole.read_bytes()[:-200])
    with pytest.raises(jaculus.InputError, match="cut.mcap: .*mcap recover"):
        jaculus.import_bag(tmp_path / "cut.mcap", tmp_path / "out", **PENDULUM)

    from mcap.writer import Writer

    with open(tmp_path / "json.mcap", "wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        schema = writer.register_schema("Log", "jsonschema", b"{}")
        channel = writer.register_channel(topic="/log", message_encoding="json", schema_id=schema)
        writer.add_message(channel, log_time=EPOCH, publish_time=EPOCH, data=b"{}")
        writer.finish()
    with pytest.raises(
        jaculus.InputError, match="not ROS's .schema encoding 'jsonschema'.*mcap filter"
    ):
        jaculus.import_bag(tmp_path / "json.mcap", tmp_path / "out", **PENDULUM)


# The command


def run(*arguments, code="import runpy; runpy.run_module('jaculus', run_name='__main__')"):
    return subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True
    )


def test_the_command_imports_bags_and_says_what_it_assumed(tmp_path):
    bag = mcap(tmp_path, bag_files.joint_states(ROWS, "pendulum"))
    options = ("--robot", "ak80_pendulum", "--experiment", "pendulum", "--controller", MEASURED)
    done = run("import", "mcap", bag, "--out", tmp_path / "out", *options)
    assert done.returncode == 0, done.stderr
    assert "headers' stamps" in done.stdout and f"written to {tmp_path}/out" in done.stdout
    assert run("check", tmp_path / "out").returncode == 0
    wrong = run("import", "mcap", tmp_path / "absent", "--out", tmp_path / "out", *options)
    assert wrong.returncode == 2 and wrong.stderr.startswith("jaculus: ")
    assert run("import", "mcap", bag, "--out", tmp_path / "out", "--robt", "x").returncode == 2


def test_without_rosbags_the_command_says_what_to_install(tmp_path):
    absent = "import sys, runpy; sys.modules['rosbags'] = None; runpy.run_module('jaculus', run_name='__main__')"
    done = run(
        "import",
        "bag",
        mcap(tmp_path, bag_files.joint_states(ROWS, "pendulum")),
        "--robot",
        "ak80_pendulum",
        "--out",
        tmp_path / "out",
        code=absent,
    )
    assert done.returncode == 2 and "pip install rosbags" in done.stderr


def test_the_program_alone_says_where_the_importer_is():
    from jaculus._command import program

    done = subprocess.run([program(), "import", "mcap", "x"], capture_output=True, text=True)
    assert done.returncode == 2 and "the command of the Python package" in done.stderr


# The diagnosis


@pytest.mark.skipif(not (SHARED / "pendulum/ak80").is_dir(), reason="no shared data")
def test_a_diagnosis_from_bags_is_the_one_from_the_csv(tmp_path):
    """Of the first 0.4 s; scripts/check_bag_diagnosis has the whole log."""
    source = SHARED / "pendulum/ak80"
    bags = []
    for trial in ("trial_01", "trial_02"):
        rows = [row for row in bag_files.rows_of(source / trial / "joints.csv") if row[0] <= 0.4]
        rows = [[round(row[0] * 1e9) / 1e9, *row[1:]] for row in rows]  # as a bag can have them
        bags.append(mcap(tmp_path, bag_files.joint_states(rows, "pendulum"), f"{trial}.mcap"))
        (tmp_path / "csv" / trial).mkdir(parents=True)
        text = "\n".join(",".join(map(repr, row)) for row in rows)
        head = (source / trial / "joints.csv").read_text().splitlines()[0]
        (tmp_path / "csv" / trial / "joints.csv").write_text(f"{head}\n{text}\n")
    text = (source / "dataset.yaml").read_text().replace("robot: robot ", f"robot: {source}/robot ")
    (tmp_path / "csv/dataset.yaml").write_text(text)

    dataset = jaculus.import_bag(
        bags,
        tmp_path / "bag/csv",
        robot=source / "robot",
        experiment="pendulum",
        controller=MEASURED,
    )
    found, same = jaculus.diagnose(dataset), jaculus.diagnose(tmp_path / "csv")
    assert found.json == same.json
    assert found.effects and found.gap["after"] < 0.5 * found.gap["before"]
