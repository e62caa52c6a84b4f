#include "client/replayer/export/column_file.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <memory>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"

namespace palpate {
namespace {

static_assert(std::endian::native == std::endian::little, "NPY files are written as memory is");

/// Width of the row count in an NPY head, enough for any count: the head is written before the rows
/// are counted.
constexpr int kCountWidth = 20;
/// NPY data begin at a multiple of this.
constexpr std::size_t kNpyAlignment = 64;

struct FileClose {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using FilePtr = std::unique_ptr<std::FILE, FileClose>;

Error CannotWrite(const std::string& file) {
  return Error(file + ": cannot be written (" + std::strerror(errno) +
               "); give another folder, or make room");
}

void WriteAll(const std::string& name, const char* mode, const std::string& bytes) {
  FilePtr file(std::fopen(name.c_str(), mode));
  if (!file || std::fwrite(bytes.data(), 1, bytes.size(), file.get()) != bytes.size() ||
      std::fflush(file.get()) != 0) {
    throw CannotWrite(name);
  }
}

}  // namespace

ColumnFormat ParseColumnFormat(const std::string& text) {
  if (text == "csv") return ColumnFormat::kCsv;
  if (text == "npy") return ColumnFormat::kNpy;
  throw UsageError("--format: '" + text + "' is not known; give csv or npy");
}

const char* Suffix(ColumnFormat format) {
  return format == ColumnFormat::kCsv ? ".csv" : ".npy";
}

ColumnFile::ColumnFile(std::string file, ColumnFormat format)
    : file_(std::move(file) + Suffix(format)), format_(format) {}

void ColumnFile::Name(const std::string& name, const std::string& type) {
  columns_.push_back({name, type});
}

void ColumnFile::Separate() {
  if (std::exchange(row_begun_, true)) pending_ += ',';
}

template <class T>
void ColumnFile::Put(T value) {
  if (format_ == ColumnFormat::kCsv) {
    Separate();
    // The shortest text that reads back to the same bits; pandas and MATLAB read "nan" and "inf".
    fmt::format_to(std::back_inserter(pending_), "{}", value);
  } else {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    pending_.append(bytes, sizeof value);
  }
}

void ColumnFile::Add(const char* name, double value) {
  if (rows_ == 0) Name(name, "<f8");
  Put(value);
}

void ColumnFile::Add(const char* name, std::uint64_t value) {
  if (rows_ == 0) Name(name, "<u8");
  Put(value);
}

void ColumnFile::Add(const char* name, std::uint32_t value) {
  if (rows_ == 0) Name(name, "<u4");
  Put(value);
}

void ColumnFile::Add(const char* name, std::string_view text, std::size_t width) {
  if (rows_ == 0) Name(name, "|S" + std::to_string(width));
  if (format_ == ColumnFormat::kNpy) {
    pending_.append(text.substr(0, width));
    pending_.append(width - std::min(width, text.size()), '\0');
    return;
  }
  Separate();
  pending_ += '"';
  for (const char c : text) pending_.append(c == '"' ? 2 : 1, c);
  pending_ += '"';
}

void ColumnFile::AddVector(const char* quantity, const char* unit, const double (&xyz)[3]) {
  for (int i = 0; i < 3; ++i) {
    if (rows_ == 0) Name(fmt::format("{}_{}_{}", quantity, "xyz"[i], unit), "<f8");
    Put(xyz[i]);
  }
}

void ColumnFile::AddPose(const char* quantity, const double (&p)[3], const double (&wxyz)[4]) {
  AddVector(quantity, "m", p);
  for (int i = 0; i < 4; ++i) {
    if (rows_ == 0) Name(fmt::format("{}_q{}", quantity, "wxyz"[i]), "<f8");
    Put(wxyz[i]);
  }
}

void ColumnFile::EndRow() {
  if (format_ == ColumnFormat::kCsv) pending_ += '\n';
  row_begun_ = false;
  ++rows_;
}

/// Returns CSV's line of names, or the head of NPY format 1.0, whose length does not depend on
/// the count.
std::string ColumnFile::Head(std::uint64_t rows) const {
  std::string text;
  if (format_ == ColumnFormat::kCsv) {
    for (const Column& column : columns_) text += (text.empty() ? "" : ",") + column.name;
    return text + "\n";
  }
  text = "{'descr': [";
  for (const Column& column : columns_) {
    text += fmt::format("('{}', '{}'), ", column.name, column.type);
  }
  text += fmt::format("], 'fortran_order': False, 'shape': ({:>{}},), }}", rows, kCountWidth);
  constexpr std::size_t kBefore = 10;  // magic, version, length
  const std::size_t unpadded = kBefore + text.size() + 1;
  text.append((kNpyAlignment - unpadded % kNpyAlignment) % kNpyAlignment, ' ');
  text += '\n';
  std::string head("\x93NUMPY\x01\x00", 8);
  head += static_cast<char>(text.size() & 0xff);
  head += static_cast<char>(text.size() >> 8);
  return head + text;
}

void ColumnFile::Flush() {
  if (pending_.empty()) return;
  if (!std::exchange(made_, true)) WriteAll(file_, "wbx", Head(0));
  WriteAll(file_, "ab", pending_);
  pending_.clear();
}

void ColumnFile::Close() {
  Flush();
  if (made_ && format_ == ColumnFormat::kNpy) WriteAll(file_, "r+b", Head(rows_));
}

}  // namespace palpate
