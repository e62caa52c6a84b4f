#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/thread_pool.hpp>

#include "client/course/access.h"
#include "client/course/course_file.h"
#include "client/course/exercise.h"

namespace palpate {

/// What is asked of a course's history: /history/class.json, class.csv, 7.json, 7.csv,
/// 7.comma.csv (CsvAs::kDecimalComma) or 7.zip.
struct HistoryWish {
  enum class As { kJson, kCsv, kCommaCsv, kZip };
  std::int64_t person = 0;  ///< 0: the class
  As as = As::kJson;
};
/// @param name  what stands behind "/history/".  Nothing for another.
std::optional<HistoryWish> ParseHistoryWish(std::string_view name);
/// A teacher reads all, anybody else what they did themselves.
/// @param reader  the number of who asks; 0: nobody of the course
bool MayRead(const HistoryWish& wish, Access access, std::int64_t reader);

/// Reads a course's history and answers what is asked of it, by a thread of its own with a
/// connection of its own to the course's file: what takes a second keeps nobody's hand waiting.
/// Thread contract: the thread that runs `io`.  The destructor waits for what is being read.
class HistoryDesk {
 public:
  struct Answer {
    int status = 200;  ///< of HTTP
    std::string type;
    std::string text;
    int file = -1;  ///< in the text's place: the receiver's to close
  };
  /// Keys of score pages, by exercise and number (TrialRoom::PagesOf).
  using Pages = std::map<std::pair<std::string, int>, std::string>;
  /// Of those who wait for an answer.
  static constexpr int kMostWaiting = 16;

  /// @param folder  of the course.
  HistoryDesk(boost::asio::io_context& io, std::string folder, std::vector<Exercise> exercises)
      : io_(io), folder_(std::move(folder)), exercises_(std::move(exercises)) {}
  ~HistoryDesk() { reader_.join(); }

  /// @param for_teacher  who asks.   @param pages  of that person.
  void Ask(HistoryWish wish, bool for_teacher, Pages pages, std::function<void(Answer)> use);

 private:
  Answer Read(const HistoryWish& wish, bool for_teacher, const Pages& pages);

  boost::asio::io_context& io_;
  const std::string folder_;
  const std::vector<Exercise> exercises_;
  int waiting_ = 0;
  std::unique_ptr<CourseFile> file_;  // the reader's
  boost::asio::thread_pool reader_{1};
};

}  // namespace palpate
