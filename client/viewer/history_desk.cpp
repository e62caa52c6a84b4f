#include "client/viewer/history_desk.h"

#include <algorithm>
#include <charconv>

#include <boost/asio/post.hpp>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include "client/course/history.h"
#include "client/course/person_data.h"
#include "common/error.h"

namespace palpate {

std::optional<HistoryWish> ParseHistoryWish(std::string_view name) {
  HistoryWish wish;
  const std::size_t dot = std::min(name.find('.'), name.size());
  const std::string_view who = name.substr(0, dot), as = name.substr(dot);
  if (as == ".csv" || as == ".comma.csv" || as == ".semicolon.csv") {
    wish.as = HistoryWish::As::kCsv;
    if (as == ".comma.csv") wish.csv = CsvAs::kDecimalComma;
    if (as == ".semicolon.csv") wish.csv = CsvAs::kSemicolon;
  } else if (as == ".zip") {
    wish.as = HistoryWish::As::kZip;
  } else if (as != ".json") {
    return std::nullopt;
  }
  if (who == "class") {
    return wish.as == HistoryWish::As::kZip ? std::nullopt : std::optional(wish);
  }
  const auto [end, error] = std::from_chars(who.data(), who.data() + who.size(), wish.person);
  if (error != std::errc() || end != who.data() + who.size() || wish.person < 1) {
    return std::nullopt;
  }
  return wish;
}

bool MayRead(const HistoryWish& wish, Access access, std::int64_t reader) {
  if (access == Access::kOperate) return true;
  return access != Access::kNone && wish.person != 0 && wish.person == reader;
}

void HistoryDesk::Ask(HistoryWish wish, bool for_teacher, Pages pages,
                      std::function<void(Answer)> use) {
  if (waiting_ == kMostWaiting) {
    return use(
        {503, "text/plain; charset=utf-8", "too many requests for the history; try again\n"});
  }
  // Each takes as much of the disk as the person's recordings, for as long as it is downloaded.
  std::shared_ptr<const void> given;
  if (wish.as == HistoryWish::As::kZip) {
    std::erase_if(given_, [](const auto& entry) { return entry.second.expired(); });
    if (given_.contains(wish.person)) {
      return use({429, "text/plain; charset=utf-8",
                  "these data are being downloaded already; end that download first\n"});
    }
    given_[wish.person] = given = std::make_shared<int>();
  }
  ++waiting_;
  boost::asio::post(
      reader_, [this, wish, for_teacher, given, pages = std::move(pages), use = std::move(use)] {
        // Low priority: the servo loops on this host have little time to spare.
        setpriority(PRIO_PROCESS, 0, 10);  // of this thread alone, on Linux
        Answer answer;
        try {
          answer = Read(wish, for_teacher, pages);
        } catch (const std::exception& error) {
          spdlog::error("history: {}", error.what());
          answer = {500, "text/plain; charset=utf-8", std::string(error.what()) + "\n"};
        }
        if (answer.file >= 0) answer.given = given;
        boost::asio::post(io_, [this, use, answer = std::move(answer)]() mutable {
          --waiting_;
          use(std::move(answer));
        });
      });
}

HistoryDesk::Answer HistoryDesk::Read(const HistoryWish& wish, bool for_teacher,
                                      const Pages& pages) {
  if (!file_) file_ = std::make_unique<CourseFile>(folder_);
  const std::vector<Person> people = RosterTable(*file_).All();
  const auto person = std::ranges::find(people, wish.person, &Person::id);
  if (wish.person != 0 && person == people.end()) {
    return {404, "text/plain; charset=utf-8", "no person of this course has that number\n"};
  }
  const History history(exercises_, people, TrialTable(*file_).Ended());
  if (wish.as == HistoryWish::As::kCsv) {
    return {200, "text/csv; charset=utf-8", history.Csv(wish.person, wish.csv)};
  }
  if (wish.as == HistoryWish::As::kZip) {
    return {200, "application/zip", "", GiveData(folder_, *person, history.Csv(wish.person))};
  }
  if (wish.person == 0) return {200, "application/json", history.ClassJson()};
  const auto page_of = [&](const TrialRow& row) {
    const auto page = pages.find({row.exercise, row.n});
    return page == pages.end() ? std::string() : page->second;
  };
  return {200, "application/json", history.PersonJson(wish.person, for_teacher, page_of)};
}

}  // namespace palpate
