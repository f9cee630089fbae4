"""Static figures of a report: its JSON on standard input, one file a chart for papers.

    figures.py FOLDER png,svg,pdf < report.json

Widths and type are those of a two-column page: 3.5 in a column, 8 pt, embedded fonts, colours that colour-blind readers can tell
apart, reference lines that differ by dash.
Prints the files that it wrote.
"""

import base64
import json
import os
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

COLUMN = 3.5  # in
PALETTE = ["#0072b2", "#d55e00", "#009e73", "#aa4499", "#b8860b", "#3aa5d8", "#6b4cc0", "#666666"]
DASHES = [":", (0, (5, 1.5)), (0, (5, 1.5, 1, 1.5)), (0, (2, 1.5))]  # of reference lines in one chart
MARK = {"published": "#6a1fb0", "limit": "#c62828", "note": "#555555"}
LOOK = {
    "font.family": "serif",
    "font.size": 8,
    "axes.labelsize": 8,
    "axes.titlesize": 8,
    "legend.fontsize": 6.5,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "axes.linewidth": 0.6,
    "lines.linewidth": 1.0,
    "axes.grid": True,
    "grid.linewidth": 0.3,
    "grid.color": "#cccccc",
    "savefig.dpi": 300,
    "pdf.fonttype": 42,
    "svg.fonttype": "path",
    "svg.hashsalt": "jaculus",  # the same bytes on every run
    "text.parse_math": False,  # names may hold dollar signs
}


def array(report, index):
    if index is None:
        return np.zeros(0)
    return np.frombuffer(base64.b64decode(report["arrays"][index]), dtype="<f4").astype(float)


def axis_title(axis):
    return axis["name"] if axis["unit"] in ("", "-") else f"{axis['name']} [{axis['unit']}]"


def draw_series(axes, report, chart):
    for number, series in enumerate(chart["series"]):
        x, y = array(report, series["x"]), array(report, series["y"])
        colour = PALETTE[(series["colour"] if series["colour"] >= 0 else number) % len(PALETTE)]
        name = series["name"]
        if series["style"] == "points":
            axes.plot(x, y, "o", color=colour, markersize=2.5, label=name)
        elif series["style"] == "steps":
            axes.step(x, y, where="post", color=colour, label=name)
        else:
            axes.plot(x, y, "--" if series["style"] == "dashed" else "-", color=colour, label=name)
        if series["low"] is not None:
            axes.fill_between(x, array(report, series["low"]), array(report, series["high"]), color=colour, alpha=0.2, linewidth=0)


def draw_marks(axes, chart):
    """Marks go into the legend: labels in the figure would cover its lines."""
    lines = 0
    for mark in chart["marks"]:
        look = {"color": MARK.get(mark["kind"], "#555555"), "label": mark["label"]}
        x, y, to = mark["x"], mark["y"], mark["xTo"]
        if x is not None and y is not None:
            axes.plot([x], [y], "D", markersize=4, zorder=5, **look)
        elif x is not None and to is not None:
            axes.axvspan(x, to, alpha=0.2, linewidth=0, **look)
        elif x is not None:
            axes.axvline(x, linestyle=DASHES[lines % len(DASHES)], linewidth=0.9, **look)
            lines += 1
        elif y is not None:
            axes.axhline(y, linestyle="-." if mark["kind"] == "limit" else DASHES[lines % len(DASHES)], linewidth=0.9, **look)
            lines += mark["kind"] != "limit"


def legend(figure, axes):
    handles, names = axes.get_legend_handles_labels()
    if len(names) < 2 and not any(n for n in names):
        return
    columns = 1 if max(len(n) for n in names) > 26 else 2
    axes.legend(handles, names, loc="upper center", bbox_to_anchor=(0.5, -0.22), ncol=columns, frameon=False, handlelength=2.2)


def chart_figure(report, chart):
    figure, axes = plt.subplots(figsize=(COLUMN, 2.3))
    draw_series(axes, report, chart)
    draw_marks(axes, chart)
    axes.set_xlabel(axis_title(chart["x"]))
    axes.set_ylabel(axis_title(chart["y"]))
    axes.set_title(chart["title"], wrap=True)
    if chart["x"]["log"]:
        axes.set_xscale("log")
    if chart["y"]["log"]:
        axes.set_yscale("log")
    low, high = chart["y"]["range"]
    axes.set_ylim(bottom=low, top=high)
    legend(figure, axes)
    return figure


def bars_figure(report, bars):
    items = bars["items"]
    figure, axes = plt.subplots(figsize=(COLUMN, 0.5 + 0.22 * len(items)))
    places = np.arange(len(items))[::-1]
    values = [np.nan if i["value"] is None else i["value"] for i in items]
    axes.barh(places, values, height=0.6, color=PALETTE[0])
    for place, item in zip(places, items):
        if item["low"] is not None and item["high"] is not None:
            axes.plot([item["low"], item["high"]], [place, place], color="black", linewidth=1)
    axes.set_yticks(places, [i["label"] for i in items])
    axes.set_title(bars["title"])
    axes.set_xlabel("" if bars["unit"] in ("", "-") else f"[{bars['unit']}]")
    axes.grid(axis="y", visible=False)
    return figure


def heat_figure(report, heat):
    values = np.array([[np.nan if v is None else v for v in row] for row in heat["values"]], dtype=float)
    figure, axes = plt.subplots(figsize=(COLUMN, 0.8 + 0.2 * len(heat["rows"])))
    axes.imshow(values, cmap="Oranges", aspect="auto", vmin=0)
    axes.grid(False)
    axes.set_xticks(range(len(heat["columns"])), heat["columns"], rotation=60, ha="right")
    axes.set_yticks(range(len(heat["rows"])), heat["rows"])
    axes.set_xlabel(heat["columnTitle"])
    axes.set_ylabel(heat["rowTitle"])
    axes.set_title(heat["title"])
    most = np.nanmax(values) if np.isfinite(values).any() else 1
    for (row, column), value in np.ndenumerate(values):
        if np.isfinite(value):
            axes.text(column, row, f"{value:.3g}", ha="center", va="center", fontsize=5.5, color="white" if value > 0.6 * most else "black")
    return figure


def save(figure, folder, name, formats):
    for extension in formats:
        file = os.path.join(folder, f"{name}.{extension}")
        metadata = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}.get(extension)
        figure.savefig(file, bbox_inches="tight", metadata=metadata)
        print(file)
    plt.close(figure)


def main():
    folder, formats = sys.argv[1], sys.argv[2].split(",")
    report = json.load(sys.stdin)
    plt.rcParams.update(LOOK)
    for section in report["sections"]:
        for chart in section["charts"]:
            if chart["figure"]:
                save(chart_figure(report, chart), folder, chart["id"], formats)
        for bars in section["bars"]:
            save(bars_figure(report, bars), folder, bars["id"], formats)
        for heat in section["heatMaps"]:
            save(heat_figure(report, heat), folder, heat["id"], formats)


if __name__ == "__main__":
    main()
