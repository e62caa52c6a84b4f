#include "tests/link/trace_file.h"

#include <cstdlib>
#include <fstream>
#include <limits>

#include "common/error.h"

namespace palpate::test {
namespace {

constexpr std::size_t kCells = 19;

std::vector<std::string> CellsOf(const std::string& line) {
  std::vector<std::string> cells;
  for (std::size_t begin = 0;;) {
    const std::size_t end = line.find(',', begin);
    cells.push_back(line.substr(begin, end - begin));
    if (end == std::string::npos) return cells;
    begin = end + 1;
  }
}

double Milliseconds(const std::string& cell) {
  return cell.empty() ? std::numeric_limits<double>::infinity() : std::atof(cell.c_str());
}

Vec3 VectorAt(const std::vector<std::string>& cells, std::size_t first) {
  return {std::atof(cells[first].c_str()), std::atof(cells[first + 1].c_str()),
          std::atof(cells[first + 2].c_str())};
}

}  // namespace

bool TraceRow::Limited(const std::string& stage) const {
  return ("+" + limiter + "+").find("+" + stage + "+") != std::string::npos;
}

std::vector<TraceRow> ReadTrace(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line) || CellsOf(line).size() != kCells || !line.starts_with("time_ns,")) {
    throw Error(file + ": is no trace of palpate-station");
  }
  std::vector<TraceRow> rows;
  while (std::getline(in, line) && !in.eof()) {
    const std::vector<std::string> cells = CellsOf(line);
    if (cells.size() != kCells) throw Error(file + ": a row has a wrong number of cells: " + line);
    rows.push_back({std::atoll(cells[0].c_str()),
                    std::strtoull(cells[1].c_str(), nullptr, 10),
                    std::strtoull(cells[2].c_str(), nullptr, 10),
                    std::strtoull(cells[3].c_str(), nullptr, 10),
                    Milliseconds(cells[4]),
                    Milliseconds(cells[5]),
                    {VectorAt(cells, 6), VectorAt(cells, 9)},
                    {VectorAt(cells, 12), VectorAt(cells, 15)},
                    cells[18]});
  }
  return rows;
}

}  // namespace palpate::test
