#include "studies/study_kind.h"

namespace jaculus::studies::detail {
namespace {

StudyMark read_mark(const yaml::Node& node) {
  node.only({"label", "x", "y", "x_to"});
  StudyMark mark{node.at("label").text()};
  if (const auto x = node.find("x")) mark.x = x->number(dimension::none);
  if (const auto y = node.find("y")) mark.y = y->number(dimension::none);
  if (const auto to = node.find("x_to")) mark.x_to = to->number(dimension::none);
  if (!node.has("x") && !node.has("y"))
    throw node.error("a mark without a place; give x, y or both");
  if (node.has("x_to") && (!node.has("x") || node.has("y")))
    throw node.error("a strip goes from x to x_to, without y");
  return mark;
}

}  // namespace

std::vector<StudyPlot> read_plots(const yaml::Node& root, const std::vector<std::string>& columns) {
  std::vector<StudyPlot> plots;
  const auto list = root.find("plots");
  if (!list) return plots;

  for (const yaml::Node& node : list->items()) {
    node.only({"title", "x", "y", "by", "marks"});
    StudyPlot plot;
    plot.title = node.at("title").text();
    plot.x = node.at("x").text();
    must_be_column(plot.x, columns, node.at("x"));

    for (const yaml::Node& y : node.at("y").items()) {
      plot.y.push_back(y.text());
      must_be_column(plot.y.back(), columns, y);
    }
    if (plot.y.empty()) throw node.at("y").error("an empty list; name one column or more");

    if (const auto by = node.find("by")) {
      plot.by = by->text();
      must_be_column(plot.by, columns, *by);
    }

    if (const auto marks = node.find("marks"))
      for (const yaml::Node& mark : marks->items()) plot.marks.push_back(read_mark(mark));

    plots.push_back(plot);
  }
  return plots;
}

}  // namespace jaculus::studies::detail
