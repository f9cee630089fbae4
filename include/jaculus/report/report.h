#pragma once
// A report as a value: what a result has to show, as plain data. write_report() makes one HTML file of it that opens from disk
// without a network (report_html.cpp), write_figures() static figures for papers (figures.cpp). Commands fill it through the builders of
// their kind (plan_report.h, study_report.h, diagnosis_report.h, ...).
//
// Numbers stand in the unit that their axis states. NaN is a gap. Series are kept whole, in single precision (7 digits): thinning is
// the viewer's business. Names may hold anything: nothing in a report is ever read as markup.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "jaculus/core/types.h"

namespace jaculus {

struct ChartAxis {
  std::string name;  ///< "time"
  std::string unit;  ///< "s"; "-" for a ratio
  bool logarithmic = false;
  Bounds range = {};  ///< shown at first; infinite ends follow the data
};

enum class SeriesStyle { line, dashed, points, steps };

struct Series {
  std::string name;
  std::vector<double> x;
  std::vector<double> y;  ///< as many as x
  SeriesStyle style = SeriesStyle::line;
  int colour = -1;                ///< index of the palette, so that kin looks alike; -1: by order
  std::vector<double> low = {};   ///< lower edge of a band about y (noise, confidence); empty: none
  std::vector<double> high = {};  ///< its upper edge
};

enum class MarkKind {
  published,  ///< a figure of the paper
  limit,      ///< what may not be passed
  note        ///< anything else
};

/// A point (x and y), a vertical line (x alone), a horizontal one (y alone) or a vertical strip (x from and to).
struct Mark {
  std::string label;
  MarkKind kind = MarkKind::published;
  double x = kNaN;
  double y = kNaN;
  double x_to = kNaN;
};

struct Chart {
  std::string id;  ///< unique in the report, [a-z0-9_]; names the files of the figure
  std::string title;
  std::string caption;
  ChartAxis x, y;
  std::vector<Series> series;
  std::vector<Mark> marks = {};
  bool over_time = false;  ///< x is the animation's time: its scrubber moves this chart's cursor
  bool figure = true;      ///< whether it is drawn as a static figure too
};

/// Cells are text; `numeric` columns are aligned right.
struct ReportTable {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
  std::string note = {};
};

/// Horizontal bars with intervals: probabilities of effects, shares of components.
struct Bars {
  struct Item {
    std::string label;
    double value = kNaN;
    double low = kNaN;  ///< interval; NaN where there is none
    double high = kNaN;
    std::string note = {};
  };
  std::string id;
  std::string title;
  std::string unit;  ///< "-": shares, shown in per cent
  std::vector<Item> items;
  std::string caption = {};
};

/// A matrix as coloured cells, rows from above.
struct HeatMap {
  std::string id;
  std::string title;
  std::string row_title, column_title;
  std::vector<std::string> rows, columns;
  std::vector<std::vector<double>> values;  ///< rows x columns
  std::string caption = {};
};

/// Lines drawn to scale in the plane, coloured by a value where there is one: a body with the share of the gap in each of its parts, a tail.
struct Drawing {
  struct Part {
    std::string name;
    std::vector<Vec2> line;  ///< x, z [m]
    double width = 0.01;     ///< [m]
    double value = kNaN;     ///< 0 to 1; NaN: plain
    std::string text = {};   ///< shown where the part is pointed at
  };
  std::string id;
  std::string title;
  std::vector<Part> parts;
  std::string caption = {};
};

/// Several drawings of which one is shown; those with a chart are chosen by its points.
struct Choice {
  std::string id;
  std::string title;
  std::string chart;  ///< id of the chart whose points choose, in order of its first series; empty: a list
  std::vector<std::string> labels;  ///< one a drawing
  std::vector<Drawing> drawings;
  int chosen = 0;
};

enum class ActorStyle { solid, ghost };

/// A body of a stick figure: a line through points that move.
struct ActorBody {
  std::string name;
  std::string kind;        ///< "base", "leg", "tail", "scoop", "link"
  int points = 0;          ///< n
  std::vector<double> xz;  ///< frames x n x 2, row by row [m]; NaN: not known, not drawn
};

/// An arrow that moves: a foot's force, drag at one place of the scoop.
struct ActorArrow {
  std::string name;
  std::string kind;           ///< "force" or "drag"
  std::vector<double> from;   ///< frames x 2 [m]
  std::vector<double> force;  ///< frames x 2 [N], or [N/m] for distributed drag
};

struct ActorPhase {
  std::string name;
  double from = 0.0, to = 0.0;  ///< [s]
};

/// One robot over time. Frames between its times are interpolated by the viewer.
struct Actor {
  std::string name;
  ActorStyle style = ActorStyle::solid;
  int colour = 0;
  std::vector<double> time;  ///< frames [s], rising
  std::vector<ActorBody> bodies;
  std::vector<ActorArrow> arrows;
  std::vector<double> com;  ///< frames x 2 [m]; empty: not drawn
  std::vector<ActorPhase> phases;
  std::vector<std::string> feet;  ///< arrows of these names stand on the floor and get a friction cone
  double friction = kNaN;         ///< half width of the cone over its height [-]; NaN: no cone
};

/// Robots that move in step with the scrubber, panels side by side.
struct Animation {
  struct Panel {
    std::string title;
    std::vector<Actor> actors;
  };
  std::string id;
  std::string title;
  std::vector<Panel> panels;
  std::string caption = {};
};

struct Section {
  std::string title;
  std::vector<std::string> text = {};  ///< paragraphs
  std::vector<Animation> animations = {};
  std::vector<ReportTable> tables = {};
  std::vector<Bars> bars = {};
  std::vector<HeatMap> heat_maps = {};
  std::vector<Drawing> drawings = {};
  std::vector<Chart> charts = {};
  std::vector<Choice> choices = {};
  bool folded = false;  ///< closed at first
};

struct Report {
  std::string title;
  std::string caption;
  std::string kind;                                             ///< "solve", "compare", ...
  std::vector<std::pair<std::string, std::string>> facts = {};  ///< the few figures that matter most
  std::vector<std::string> notices = {};                        ///< what to mind, above everything else
  std::vector<Section> sections = {};
};

/// The text of report.html. Without the built web assets it holds tables and a notice that charts are missing.
std::string report_html(const Report& report);

/// Writes `folder`/report.html and returns its path. The folder must exist; unwritable: InputError.
std::filesystem::path write_report(const Report& report, const std::filesystem::path& folder);

/// Formats of figures as given on a command line, "png,svg". InputError on another word.
std::vector<std::string> figure_formats(const std::string& given);

/// InputError where figures can't be drawn here, so that a command can say so before its work.
void require_figures();

/// Draws every chart, bars and heat map as `folder`/figures/<id>.<format> by matplotlib, at the width of a journal's column. Returns the files.
/// InputError where python3 with matplotlib is not there.
std::vector<std::filesystem::path> write_figures(const Report& report, const std::filesystem::path& folder,
                                                 const std::vector<std::string>& formats);

/// A name as an id: lower case, everything but letters and digits as '_'.
std::string report_id(const std::string& name);

}  // namespace jaculus
