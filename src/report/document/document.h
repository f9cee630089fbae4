#pragma once
// What a report is made of, as values: charts, tables, figures, robots in motion. Builders
// (plan_report.cpp, study_report.cpp, ...) fill a Document; the JSON, the page and the static
// figures are made of it.
//
// Numbers stand in the unit that their axis states. NaN is a gap. Series are kept whole, in single
// precision (7 digits): thinning is the viewer's business. Names may hold anything: nothing in a
// document is ever read as markup.

#include <string>
#include <utility>
#include <vector>

#include "jaculus/core/types.h"
#include "jaculus/report/report.h"

namespace jaculus::report {

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

/// A point (x and y), a vertical line (x alone), a horizontal one (y alone) or a vertical strip (x
/// from and to).
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

/// Lines drawn to scale in the plane, coloured by a value where there is one: a body with the share
/// of the gap in each of its parts, a tail.
struct Drawing {
  struct Part {
    std::string name;
    std::vector<Vec2> line;  ///< x, z [m]
    double width = 0.01;     ///< [m]
    double value = kNaN;     ///< 0 to 1; NaN: plain
    std::string text = {};   ///< shown where the part is pointed at
    std::string style = {};  ///< of report.css (measured, assumed, nominal, augmented, force)
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
  /// id of the chart whose points choose, in order of its first series; empty: a list
  std::string chart;
  std::vector<std::string> labels;  ///< one a drawing
  std::vector<Drawing> drawings;
  int chosen = 0;
};

/// Drawings side by side at one scale, each with its title and caption.
struct Picture {
  std::string id = {};
  std::string title = {};
  std::vector<Drawing> panels = {};
  std::vector<std::pair<std::string, std::string>> legend = {};  ///< a part's style and its meaning
  std::string caption = {};
};

enum class ActorStyle { solid, ghost };

/// What a line of a stick figure stands for; the viewer draws each kind in its own width.
enum class BodyKind { base, leg, tail, scoop, link };

/// A body of a stick figure: a line through points that move.
struct ActorBody {
  std::string name;
  BodyKind kind = BodyKind::link;
  int points = 0;          ///< n
  std::vector<double> xz;  ///< frames x n x 2, row by row [m]; NaN: not known, not drawn
};

enum class ArrowKind { force, drag };

/// An arrow that moves: a foot's force, drag at one place of the scoop.
struct ActorArrow {
  std::string name;
  ArrowKind kind = ArrowKind::force;
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
  /// arrows of these names stand on the floor and get a friction cone
  std::vector<std::string> feet;
  double friction = kNaN;  ///< half width of the cone over its height [-]; NaN: no cone
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

struct Document {
  std::string title;
  std::string caption;
  std::string kind;  ///< "solve", "compare", ...
  /// the few figures that matter most
  std::vector<std::pair<std::string, std::string>> facts = {};
  std::vector<std::string> notices = {};  ///< what to mind, above everything else
  std::vector<Section> sections = {};
  /// the answer in sentences, each with the question that it answers; first on the page
  std::vector<std::pair<std::string, std::string>> summary = {};
  Picture picture = {};  ///< what the summary says, drawn; none without panels
};

/// A finished document as a report.
Report finished(Document document);

/// A name as an id: lower case, everything but letters and digits as '_'.
std::string report_id(const std::string& name);

/// A name as words: "front_a" is "front a".
std::string plain(std::string name);

}  // namespace jaculus::report
