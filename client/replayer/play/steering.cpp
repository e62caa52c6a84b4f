#include "client/replayer/play/steering.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>

#include <spdlog/spdlog.h>

#include "common/dds/random_run.h"
#include "common/error.h"

namespace palpate {
namespace {

constexpr double kLeastRate = 0.1, kMostRate = 8.0;

}  // namespace

Steering::Steering(const dds::Participant& service, const std::string& recording,
                   const Timeline& timeline, bool locked)
    : timeline_(timeline),
      bookmarks_(Bookmarks::FileFor(recording)),
      recording_(std::filesystem::path(recording).filename().string()),
      locked_(locked),
      replay_(RandomRun()),
      contents_(service, dds::kReplayContentsTopic, dds::Qos::kSession),
      states_(service, dds::kReplayStateTopic, dds::Qos::kSession),
      requests_(service, dds::kReplayRequestTopic, dds::Qos::kRecordSession) {
  TellContents();
}

double Steering::Seconds(std::int64_t time_ns) const {
  return 1e-9 * static_cast<double>(time_ns - timeline_.first_ns());
}

void Steering::GatherMarks() {
  marks_.clear();
  for (const Bookmarks::Bookmark& bookmark : bookmarks_.all()) {
    wire::ReplayMark& mark = marks_.emplace_back();
    mark.at_s = bookmark.at_s;
    mark.number = bookmark.number;
    mark.kind = palpate_REPLAY_BOOKMARK;
    wire::FromText(bookmark.name, mark.text);
  }
  for (const Timeline::Mark& held : timeline_.marks()) {
    wire::ReplayMark& mark = marks_.emplace_back();
    mark.at_s = Seconds(held.time_ns);
    mark.kind = held.kind;
    wire::FromText(held.text, mark.text);
  }
  std::ranges::stable_sort(marks_, {}, &wire::ReplayMark::at_s);
}

void Steering::TellContents() {
  GatherMarks();
  std::vector<wire::ReplayGap> gaps;
  for (const Timeline::Gap& held : timeline_.gaps()) {
    wire::ReplayGap& gap = gaps.emplace_back();
    gap.from_s = Seconds(held.from_ns);
    gap.to_s = Seconds(held.to_ns);
    wire::FromText(held.station, gap.station);
    wire::FromText(held.reason, gap.reason);
  }
  wire::ReplayContents contents{};
  contents.replay = replay_;
  wire::FromText(recording_, contents.recording);
  contents.begun_ns = timeline_.first_ns();
  contents.length_s = Seconds(timeline_.last_ns());
  contents.locked = locked_;
  contents.marks._buffer = marks_.data();
  contents.marks._length = contents.marks._maximum = static_cast<std::uint32_t>(marks_.size());
  contents.gaps._buffer = gaps.data();
  contents.gaps._length = contents.gaps._maximum = static_cast<std::uint32_t>(gaps.size());
  // If DDS refuses it, it is sent with the next state.
  contents_told_ = contents_.Write(contents);
}

/// DDS delivers requests kind by kind, but the order of a play and a pause matters: sorts by time.
void Steering::TakeWishes() {
  dds::CdrSample raw;
  wire::ReplayRequest request{};
  while (requests_.Take(raw, request)) {
    if (request.replay != replay_ || !requests_heard_.IsNew(request.request)) continue;
    wishes_.push_back({raw.source_time_ns, request});
  }
  std::ranges::stable_sort(wishes_, {}, &Wish::time_ns);
}

bool Steering::Take(const State& now, wire::ReplayRequest& request) {
  TakeWishes();
  while (!wishes_.empty()) {
    request = wishes_.front().request;
    wishes_.pop_front();
    answered_ = request.request;
    refusal_.clear();
    try {
      Check(request);
      steered_ = true;
      if (!KeepBookmark(request)) return true;
    } catch (const Error& error) {
      refusal_ = error.what();
      spdlog::info("a viewer's request is refused: {}", refusal_);
    }
    Tell(now);
  }
  return false;
}

void Steering::Check(const wire::ReplayRequest& request) const {
  if (locked_) {
    throw Error("this replay is steered at its own terminal (palpate-replay --locked)");
  }
  const bool has_value =
      request.wish != palpate_REPLAY_PLAY && request.wish != palpate_REPLAY_PAUSE;
  if (has_value && !std::isfinite(request.value))
    throw Error("its value is not a number; give one");
  if (request.wish == palpate_REPLAY_RATE &&
      !(request.value >= kLeastRate && request.value <= kMostRate)) {
    throw Error("the rate must be from 0.1 to 8");
  }
}

bool Steering::KeepBookmark(const wire::ReplayRequest& request) {
  if (request.wish == palpate_REPLAY_ADD_BOOKMARK) {
    AddBookmark(request.value, request.text);
  } else if (request.wish == palpate_REPLAY_DROP_BOOKMARK) {
    const double number = request.value;
    const bool is_number = number >= 1.0 && number < 4e9 && number == std::floor(number);
    bookmarks_.Drop(is_number ? static_cast<std::uint32_t>(number) : 0);
    TellContents();
  } else {
    return false;
  }
  return true;
}

void Steering::AddBookmark(double at_s, const std::string& name) {
  bookmarks_.Add(std::clamp(at_s, 0.0, Seconds(timeline_.last_ns())), name);
  TellContents();
}

std::optional<double> Steering::MarkAfter(double at_s) const {
  const auto mark = std::ranges::upper_bound(marks_, at_s, {}, &wire::ReplayMark::at_s);
  return mark == marks_.end() ? std::nullopt : std::optional(mark->at_s);
}

std::optional<double> Steering::MarkBefore(double at_s) const {
  const auto mark = std::ranges::lower_bound(marks_, at_s, {}, &wire::ReplayMark::at_s);
  return mark == marks_.begin() ? std::nullopt : std::optional(std::prev(mark)->at_s);
}

void Steering::Tell(const State& state) {
  if (!contents_told_) TellContents();
  wire::ReplayState sample{};
  sample.replay = replay_;
  sample.at_s = state.at_s;
  sample.rate = state.rate;
  sample.sought = state.sought;
  sample.playing = state.playing;
  sample.ended = state.ended;
  sample.request = answered_;
  wire::FromText(refusal_, sample.refusal);
  states_.Write(sample);
}

}  // namespace palpate
