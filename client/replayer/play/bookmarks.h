#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace palpate {

/// Named moments of a recording.  They are stored in a file beside it, which people can read, edit
/// and pass on with it; the recording itself never changes.
class Bookmarks {
 public:
  struct Bookmark {
    std::uint32_t number;  ///< from 1, valid while this object lives
    double at_s;           ///< from the recording's beginning
    std::string name;
  };
  static constexpr std::size_t kMost = 200;
  static constexpr std::size_t kLongestName = 100;  ///< [bytes]

  /// Returns "lesson.bookmarks.json" for "lesson.mcap".
  static std::string FileFor(const std::string& recording);

  /// Reads the file if it exists.  Throws Error (file, line, remedy) if it is not a bookmark file.
  explicit Bookmarks(std::string file);

  /// Adds a bookmark, after writing it to the file.  Throws Error (reason, remedy) without any
  /// change if that fails.  Does not overwrite a file that someone else has changed meanwhile.
  void Add(double at_s, const std::string& name);
  void Drop(std::uint32_t number);
  const std::vector<Bookmark>& all() const { return bookmarks_; }  ///< by time

 private:
  void Write(std::vector<Bookmark> bookmarks);

  std::string file_;
  std::string text_;  // the file's text when last read or written; empty: no file
  std::vector<Bookmark> bookmarks_;
  std::uint32_t next_ = 1;
};

}  // namespace palpate
