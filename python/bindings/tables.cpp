// Tables of numbers with named columns.

#include <nanobind/eigen/dense.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::python {

void bind_tables(nb::module_& module) {
  using trajectory::Table;
  nb::class_<Table>(module, "Table", "A table of numbers; an empty cell is NaN.")
      .def_prop_ro(
          "names",
          [](const Table& table) {
            std::vector<std::string> names;
            for (const trajectory::Column& column : table.columns) names.push_back(column.name);
            return names;
          },
          "Names of the columns.")
      .def_prop_ro(
          "units",
          [](const Table& table) {
            std::vector<std::string> units;
            for (const trajectory::Column& column : table.columns) units.push_back(column.unit);
            return units;
          },
          "Units of the columns, empty where there is none.")
      .def_ro("values", &Table::values, "Array of shape (rows, columns).")
      .def_ro("phase", &Table::phase, "Name of the phase of each row; empty where there are none.");
}

}  // namespace jaculus::python
