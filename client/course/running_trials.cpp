#include "client/course/running_trials.h"

#include <algorithm>

#include <fmt/format.h>

#include "common/error.h"

namespace palpate {

TrialNews NewsOf(const TrialRow& row) {
  TrialNews news;
  news.person = row.person;
  news.exercise = row.exercise;
  news.n = row.n;
  news.reason = row.reason;
  news.whole = row.whole;
  news.submitted = row.submitted_s.has_value();
  return news;
}

bool RunningTrials::is_running(TrialHolder holder) const {
  return std::ranges::any_of(all, [&](const RunningTrial& trial) {
    return trial.news.holder == holder && trial.news.phase == "running";
  });
}

bool RunningTrials::is_at_one(TrialHolder holder) const {
  return std::ranges::any_of(
      all, [&](const RunningTrial& trial) { return trial.news.holder == holder && trial.records; });
}

TrialHolder RunningTrials::HolderOf(std::int64_t person) const {
  const auto runs = std::ranges::find_if(all, [&](const RunningTrial& trial) {
    return trial.news.person == person && trial.news.phase == "running";
  });
  return runs == all.end() ? 0 : runs->news.holder;
}

bool RunningTrials::is_in(const std::string& scene) const {
  return std::ranges::any_of(
      all, [&](const RunningTrial& trial) { return trial.records && trial.scene == scene; });
}

bool RunningTrials::is_cut_in(const std::string& scene) const {
  return std::ranges::any_of(all, [&](const RunningTrial& trial) {
    return trial.records && trial.scene == scene && AsksForCuts(trial.exercise->criteria);
  });
}

bool RunningTrials::has_one_of(std::int64_t person) const {
  return std::ranges::any_of(
      all, [&](const RunningTrial& trial) { return trial.news.person == person; });
}

bool RunningTrials::Has(const TrialKey& key) const {
  return std::ranges::any_of(all,
                             [&](const RunningTrial& trial) { return trial.news.key() == key; });
}

void RunningTrials::CheckMayBegin(std::int64_t person) const {
  const auto theirs = std::ranges::find_if(all, [&](const RunningTrial& trial) {
    return trial.news.person == person && trial.news.holder != 0;
  });
  if (theirs == all.end()) return;
  if (theirs->retry_ns != 0) {
    throw Error(fmt::format(
        "your last trial is over and its recording is kept, but it cannot be entered: {}. It is "
        "entered as soon as that is mended, and then you may begin; tell your teacher",
        theirs->trouble));
  }
  throw Error(theirs->records ? "a trial of yours is running; end it first"
                              : "your last trial is being scored; wait for its points");
}

}  // namespace palpate
