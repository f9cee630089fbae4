// Uses the installed library from outside; exits with 0 where it does what it says.
#include <filesystem>
#include <string>

#include "jaculus/core/units.h"
#include "jaculus/trajectory/csv.h"

int main(int argc, char** argv) {
  if (argc != 2 || !std::filesystem::is_directory(SHARE_DIR)) return 1;
  const std::filesystem::path file = std::filesystem::path(argv[1]) / "consumer.csv";
  jaculus::trajectory::Table table{
      {{"voltage", "V"}},
      jaculus::Matrix::Constant(1, 1, jaculus::parse_quantity("7 V", jaculus::dimension::voltage)),
      {}};
  jaculus::trajectory::write_csv(table, file);
  return jaculus::trajectory::read_csv(file).values(0, 0) == 7.0 ? 0 : 2;
}
