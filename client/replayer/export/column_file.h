#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

enum class ColumnFormat {
  kCsv,  ///< a line of names, then one line per row (RFC 4180); numbers read back to the same bits
  kNpy,  ///< a structured NumPy array, format 1.0
};

/// Parses "csv" or "npy"; throws UsageError.
ColumnFormat ParseColumnFormat(const std::string& text);
/// Returns ".csv" or ".npy".
const char* Suffix(ColumnFormat format);

/// A table that is written row by row: the first row defines the columns, and every later row
/// gives the same columns in the same order.  Rows wait in memory until Flush, and no file stays
/// open, so that a recording of thousands of sessions can be exported in one pass.  Thread
/// contract: one thread.
class ColumnFile {
 public:
  /// @param file  without its suffix.  It is created by the first Flush that has a row.
  ColumnFile(std::string file, ColumnFormat format);

  void Add(const char* name, double value);
  void Add(const char* name, std::uint64_t value);
  void Add(const char* name, std::uint32_t value);
  /// @param width  field width in the NPY format, in bytes; longer text is truncated there.
  void Add(const char* name, std::string_view text, std::size_t width);
  /// Adds x, y and z as columns quantity_x_unit and so on.
  void AddVector(const char* quantity, const char* unit, const double (&xyz)[3]);
  /// Adds columns quantity_x_m, _y_m, _z_m, and quantity_qw, _qx, _qy, _qz for the unit quaternion.
  void AddPose(const char* quantity, const double (&p)[3], const double (&wxyz)[4]);
  void EndRow();

  /// Appends the waiting rows to the file.  Throws Error (file, the system's reason).
  void Flush();
  /// Flushes, and writes the count of rows if the format has one.  Nothing may be added after that.
  void Close();

  /// Returns the size of the waiting rows, in bytes.
  std::size_t pending() const { return pending_.size(); }
  std::uint64_t rows() const { return rows_; }
  /// With the suffix.
  const std::string& file() const { return file_; }

 private:
  struct Column {
    std::string name;
    std::string type;  ///< in NumPy's notation: "<f8"
  };
  void Name(const std::string& name, const std::string& type);
  void Separate();
  template <class T>
  void Put(T value);
  std::string Head(std::uint64_t rows) const;

  std::string file_;
  ColumnFormat format_;
  std::vector<Column> columns_;
  std::string pending_;
  std::uint64_t rows_ = 0;
  bool row_begun_ = false;
  bool made_ = false;
};

}  // namespace palpate
