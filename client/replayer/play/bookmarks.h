#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace palpate {

/// Names that people have given to moments of a recording.  They live in a file beside it, which a
/// person can read, mend and hand on with it; the recording itself stays as it was recorded.
class Bookmarks {
 public:
  struct Bookmark {
    std::uint32_t number;  ///< from 1, while this object lives
    double at_s;           ///< from the recording's beginning
    std::string name;
  };
  static constexpr std::size_t kMost = 200;
  static constexpr std::size_t kLongestName = 100;  ///< [bytes]

  /// "lesson.bookmarks.json" for "lesson.mcap".
  static std::string FileFor(const std::string& recording);

  /// Reads the file, if it is there.  Throws Error (file, line, remedy) where it is no such file.
  explicit Bookmarks(std::string file);

  /// Written to the file before it is there; throws Error (why not, remedy) and is as before.  What
  /// somebody else has written there meanwhile is not written over.
  void Add(double at_s, const std::string& name);
  void Drop(std::uint32_t number);
  const std::vector<Bookmark>& all() const { return bookmarks_; }  ///< by time

 private:
  void Write(std::vector<Bookmark> bookmarks);

  std::string file_;
  std::string text_;  // of the file as it was last seen; empty: there was none
  std::vector<Bookmark> bookmarks_;
  std::uint32_t next_ = 1;
};

}  // namespace palpate
