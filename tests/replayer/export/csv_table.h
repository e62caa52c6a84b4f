#pragma once

#include <cstdlib>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/read_file.h"

namespace palpate::test {

/// A table as any CSV reader has it: columns by name, as text or as doubles.
struct Table {
  std::vector<std::string> names;
  std::map<std::string, std::vector<std::string>> text;

  std::vector<double> Numbers(const std::string& name) const {
    EXPECT_TRUE(text.contains(name)) << name;
    std::vector<double> numbers;
    for (const std::string& cell : text.at(name)) {
      numbers.push_back(std::strtod(cell.c_str(), nullptr));
    }
    return numbers;
  }
  std::size_t rows() const { return names.empty() ? 0 : text.at(names[0]).size(); }
};

/// Parses RFC 4180 by its grammar, independently of the writer.
inline Table ReadCsv(const std::string& file) {
  Table table;
  std::vector<std::vector<std::string>> lines(1);
  std::string cell;
  bool quoted = false;
  const std::string all = ReadWholeFile(file);
  EXPECT_FALSE(all.empty()) << file;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const char c = all[i];
    if (quoted && c == '"' && i + 1 < all.size() && all[i + 1] == '"') {
      cell += all[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (!quoted && (c == ',' || c == '\n')) {
      lines.back().push_back(std::exchange(cell, ""));
      if (c == '\n') lines.emplace_back();
    } else {
      cell += c;
    }
  }
  EXPECT_TRUE(lines.back().empty()) << file << " does not end with a line";
  lines.pop_back();
  if (lines.empty()) return table;
  table.names = lines[0];
  for (std::size_t i = 1; i < lines.size(); ++i) {
    EXPECT_EQ(lines[i].size(), table.names.size()) << file << ", line " << i + 1;
    for (std::size_t k = 0; k < lines[i].size(); ++k) {
      table.text[table.names[k]].push_back(lines[i][k]);
    }
  }
  return table;
}

}  // namespace palpate::test
