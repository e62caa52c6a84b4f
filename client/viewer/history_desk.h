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
#include "client/course/history.h"

namespace palpate {

/// A request for a course's history: /history/class.json, class.csv, 7.json, 7.csv, 7.comma.csv,
/// 7.semicolon.csv (as in CsvAs) or 7.zip.
struct HistoryWish {
  enum class As { kJson, kCsv, kZip };
  std::int64_t person = 0;  ///< 0: the class
  As as = As::kJson;
  CsvAs csv = CsvAs::kRfc4180;
};
/// @param name  the path behind "/history/".  Returns nothing if it is no such request.
std::optional<HistoryWish> ParseHistoryWish(std::string_view name);
/// Returns whether the request is allowed: a teacher may read everything, anybody else their own.
/// @param reader  number of the person who asks; 0: nobody of the course.
bool MayRead(const HistoryWish& wish, Access access, std::int64_t reader);

/// Answers requests for a course's history in its own thread, with its own connection to the
/// course's file, so that a slow query does not delay the network thread.
/// Thread contract: the thread that runs `io`.  The destructor waits for a running query.
class HistoryDesk {
 public:
  struct Answer {
    int status = 200;  ///< HTTP status
    std::string type;
    std::string text;
    int file = -1;  ///< descriptor in place of the text; the receiver closes it
    /// Held as long as that file is: meanwhile nobody else is given the same person's.
    std::shared_ptr<const void> given = {};
  };
  /// Keys of score pages, by exercise and number (TrialRoom::PagesOf).
  using Pages = std::map<std::pair<std::string, int>, std::string>;
  /// Limit of requests that wait for an answer.
  static constexpr int kMostWaiting = 16;

  /// @param folder  of the course.
  HistoryDesk(boost::asio::io_context& io, std::string folder, std::vector<Exercise> exercises)
      : io_(io), folder_(std::move(folder)), exercises_(std::move(exercises)) {}
  ~HistoryDesk() { reader_.join(); }

  /// @param for_teacher  a teacher asks.   @param pages  of the requested person.
  void Ask(HistoryWish wish, bool for_teacher, Pages pages, std::function<void(Answer)> use);

 private:
  Answer Read(const HistoryWish& wish, bool for_teacher, const Pages& pages);

  boost::asio::io_context& io_;
  const std::string folder_;
  const std::vector<Exercise> exercises_;
  int waiting_ = 0;
  std::map<std::int64_t, std::weak_ptr<const void>> given_;  // by person
  std::unique_ptr<CourseFile> file_;                         // used by the reader only
  boost::asio::thread_pool reader_{1};
};

}  // namespace palpate
