#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// The end of each error message about a file that violates its format.
inline constexpr const char* kExportAgain =
    "; the file is damaged, or in another format than its name says: export it again";

/// Reads the text of a mesh file word by word.  Every character that is not printable is a
/// blank; a line ends with LF, CR LF or CR.  Error messages name the line.  A view: the text
/// must outlive it.
class MeshText {
 public:
  /// Skips a byte order mark.  Throws Error if the text is UTF-16.
  explicit MeshText(std::string_view text);

  bool done() const { return at_ == text_.size(); }
  /// Returns the text that has not been read.
  std::string_view rest() const { return text_.substr(at_); }

  /// Reads the next word, on whichever line; empty at the end.
  std::string_view Word();
  /// Reads the next word as a double, which may be inf or nan.
  double Number();
  /// Reads the rest of the line, without its end and surrounding blanks, and goes to the next line.
  std::string_view Line();

  /// Reads the next word on a line of an OBJ; empty at the line's end.  A backslash at its end
  /// continues the line, and a comment (#) ends it.
  std::string_view WordOfLine();
  /// Skips the rest of such a line.
  void EndLine();

  /// Throws Error "line 12: why", with the remedy.
  [[noreturn]] void Fail(const std::string& why) const;

 private:
  void SkipBlanks();
  bool AtLineEnd() const { return text_[at_] == '\n' || text_[at_] == '\r'; }
  /// Returns whether a backslash here ends the line.
  bool AtJoint() const;
  void SkipLineEnd();

  std::string_view text_;
  std::size_t at_ = 0;
};

/// Reads a word as a number, which may have a leading plus; returns whether it is one.
bool ReadNumber(std::string_view word, double& value);

}  // namespace palpate
