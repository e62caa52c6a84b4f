#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// What is done about a file that is not as its format says: the end of each complaint.
inline constexpr const char* kExportAgain =
    "; the file is damaged, or in another format than its name says: export it again";

/// A mesh file's text, read word by word.  A blank is whatever is not printed, and a line ends with
/// LF, CR LF, or CR, as writers of all times have it.  What complains says in which line.
/// Views: the text must outlive it.
class MeshText {
 public:
  /// Passes over a byte order mark.  Throws Error where the text is UTF-16.
  explicit MeshText(std::string_view text);

  bool done() const { return at_ == text_.size(); }
  /// What has not been read.
  std::string_view rest() const { return text_.substr(at_); }

  /// The next word, in whichever line; empty at the end.
  std::string_view Word();
  /// The next word as a number of double precision, which may be inf or nan.
  double Number();
  /// The rest of the line, without its end and without blanks around it; then the next line begins.
  std::string_view Line();

  /// The next word of a line of an OBJ; empty at its end.  A line goes on behind a backslash at its
  /// end, and a comment (#) ends it.
  std::string_view WordOfLine();
  /// Leaves that line, with what stands in it.
  void EndLine();

  /// Throws Error "line 12: why", with the remedy.
  [[noreturn]] void Fail(const std::string& why) const;

 private:
  void SkipBlanks();
  bool AtLineEnd() const { return text_[at_] == '\n' || text_[at_] == '\r'; }
  /// At a backslash that ends a line.
  bool AtJoint() const;
  void SkipLineEnd();

  std::string_view text_;
  std::size_t at_ = 0;
};

/// Whether a word is a number, which a plus may stand before.
bool ReadNumber(std::string_view word, double& value);

}  // namespace palpate
