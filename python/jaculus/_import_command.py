"""jaculus import mcap, bag, parquet: the part of the command that Python does."""

from __future__ import annotations

import argparse
import json
import sys
from typing import NoReturn, Optional

from ._errors import InputError

KINDS = ("mcap", "bag", "parquet")


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        print(f"jaculus: import: {message}; allowed: see {self.prog} --help", file=sys.stderr)
        sys.exit(2)


def _parser(kind: str) -> argparse.ArgumentParser:
    bags = kind != "parquet"
    parser = _Parser(
        prog=f"jaculus import {kind}",
        allow_abbrev=False,
        description=(
            "ROS 2 bags (MCAP, sqlite3) into a dataset; prints what was assumed and left out."
            if bags
            else "Parquet tables into a dataset; prints what was left out."
        ),
    )
    parser.add_argument(
        "files",
        nargs="+",
        help="bags, a trial each: folder, .mcap or .db3" if bags else "tables, a trial each",
    )
    parser.add_argument("--out", required=True, help="folder of the dataset")
    parser.add_argument("--robot", required=True, help="the robot: a folder of models/, or a path")
    if bags:
        parser.add_argument(
            "--columns", help="which topics and fields are taken, YAML, format jaculus-bag/1"
        )
        parser.add_argument(
            "--definitions",
            nargs="+",
            default=[],
            help="PACKAGE/msg/NAME.msg, or folders of such, of types that a bag doesn't define",
        )
    else:
        parser.add_argument(
            "--map",
            dest="columns",
            required=True,
            help="columns of the channels, YAML, format jaculus-columns/1",
        )
    parser.add_argument(
        "--experiment", default="leap", help="leap (default), self_righting, tail_bench, pendulum"
    )
    parser.add_argument("--plan", default="", help="plan.csv that was commanded")
    parser.add_argument(
        "--controller", default="", help='as in dataset.yaml: "{kind: measured, input: torque}"'
    )
    parser.add_argument("--provenance", default="", help="where the logs come from")
    parser.add_argument(
        "--start",
        help=(
            "time zero: first, plan, seconds of the log, CHANNEL>VALUE"
            if bags
            else "time zero: first, seconds of the file, CHANNEL>VALUE"
        ),
    )
    parser.add_argument("--cut", help="FROM,TO: seconds about time zero that are kept")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")
    parser.add_argument(
        "--json", action="store_true", help="machine-readable result on standard output"
    )
    return parser


def _cut(text: Optional[str]) -> Optional[tuple[float, float]]:
    if text is None:
        return None
    try:
        begin, end = map(float, text.split(","))
    except ValueError:
        raise InputError(f"--cut: '{text}' given; allowed: FROM,TO in seconds") from None
    return begin, end


def _run(kind: str, arguments: list[str]) -> None:
    from .logs import import_bag, import_table

    given = _parser(kind).parse_args(arguments)
    options = {
        "robot": given.robot,
        "columns": given.columns,
        "experiment": given.experiment,
        "plan": given.plan,
        "controller": given.controller,
        "cut": _cut(given.cut),
        "provenance": given.provenance,
    }
    if kind == "parquet":
        dataset = import_table(given.files, given.out, start=given.start or "first", **options)
    else:
        dataset = import_bag(
            given.files, given.out, start=given.start, definitions=given.definitions, **options
        )

    if given.json:
        streams = {
            t.name: {
                s.name: {"samples": len(s.time), "channels": s.channels} for s in t.streams.values()
            }
            for t in dataset.trials
        }
        print(
            json.dumps({"files": given.files, "trials": streams, "notes": dataset.notes}, indent=1)
        )
    elif not given.quiet:
        print(f"{dataset.summary}\nwritten to {given.out}")


def run(arguments: list[str]) -> int:
    """`arguments` after `jaculus import`; the exit code, 2 for bad input."""
    try:
        _run(arguments[0], arguments[1:])
    except (InputError, ImportError) as fault:
        print(f"jaculus: {fault}", file=sys.stderr)
        return 2
    return 0
