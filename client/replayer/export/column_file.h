#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

enum class ColumnFormat {
  kCsv,  ///< a line of names, then one for each row (RFC 4180); numbers that read back to all bits
  kNpy,  ///< an array of NumPy with named fields, format 1.0
};

/// Parses "csv", "npy"; throws UsageError.
ColumnFormat ParseColumnFormat(const std::string& text);
/// ".csv", ".npy"
const char* Suffix(ColumnFormat format);

/// A table that is written row by row: the first row names its columns, and every later one gives
/// the same columns in the same order.  Rows wait in memory until Flush, and no file stays open, so
/// that a recording of thousands of sessions can be written at once.  Thread contract: one thread.
class ColumnFile {
 public:
  /// @param file  without its suffix.  Nothing is written before the first Flush with a row.
  ColumnFile(std::string file, ColumnFormat format);

  void Add(const char* name, double value);
  void Add(const char* name, std::uint64_t value);
  void Add(const char* name, std::uint32_t value);
  /// @param width  that the NPY format keeps, in bytes; what is longer is cut there.
  void Add(const char* name, std::string_view text, std::size_t width);
  /// x, y, z: columns quantity_x_unit and so on.
  void AddVector(const char* quantity, const char* unit, const double (&xyz)[3]);
  /// quantity_x_m, _y_m, _z_m, and the unit quaternion quantity_qw, _qx, _qy, _qz.
  void AddPose(const char* quantity, const double (&p)[3], const double (&wxyz)[4]);
  void EndRow();

  /// Appends what waits to the file.  Throws Error (file, the system's reason).
  void Flush();
  /// Flush, and the count of rows where the format has one.  Nothing may be added any more.
  void Close();

  /// Waiting, in bytes.
  std::size_t pending() const { return pending_.size(); }
  std::uint64_t rows() const { return rows_; }
  /// With its suffix.
  const std::string& file() const { return file_; }

 private:
  struct Column {
    std::string name;
    std::string type;  ///< as NumPy writes it: "<f8"
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
