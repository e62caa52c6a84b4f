#include "client/replayer/verify/cut_replay.h"

#include <algorithm>

namespace palpate {
namespace {

constexpr const char* kBefore =
    "what burs had cut before the recording began is not in it; make the scene whole, then record";

std::string NotComputed(const std::string& station) {
  return "what the bur of station " + station +
         " had cut by then is not known: its session could not be computed to there";
}

}  // namespace

bool CutFacts::IsHeld(std::uint64_t pose_sequence) const {
  return std::ranges::any_of(held, [&](const auto& poses) {
    return poses.first <= pose_sequence && pose_sequence < poses.second;
  });
}

void CutLogFacts::Add(const wire::CutLog& sample) {
  Sample& one = samples_[sample.number];
  one.begun = {sample.begun_station, sample.begun_run};
  one.events.assign(sample.events._buffer, sample.events._buffer + sample.events._length);
}

std::map<std::pair<std::string, std::uint64_t>, CutFacts> CutLogFacts::Sessions() const {
  std::map<std::uint32_t, CutFacts> facts;
  std::map<std::pair<std::string, std::uint64_t>, std::uint32_t> numbers;
  struct Given {
    std::uint64_t all = 0, merged = 0;  // number of blocks
    std::uint64_t known = 0;            // up to this pose
  };
  std::map<std::uint32_t, Given> given;
  for (const auto& [number, sample] : samples_) {
    for (const wire::CutEvent& event : sample.events) {
      CutFacts& of = facts[event.session];
      Given& its = given[event.session];
      switch (event.step) {
        case palpate_CUT_BEGUN:
          numbers[sample.begun] = of.session = event.session;
          break;
        case palpate_CUT_HELD:
          of.held.emplace_back(event.pose_sequence, event.other);
          break;
        case palpate_CUT_GIVEN:
          its.all += event.count;
          its.known = std::max(its.known, event.pose_sequence);
          break;
        case palpate_CUT_MERGED:
          of.merges[event.pose_sequence] = {event.pose_sequence, event.other, event.count};
          its.merged = std::max(its.merged, event.other + event.count - 1);
          its.known = std::max(its.known, event.pose_sequence);
          break;
        case palpate_CUT_ENDED:
          of.ended = event;
          break;
        case palpate_CUT_WHOLE:
        case palpate_CUT_BACK:
          // Blocks given before are void.
          for (auto& [session, one] : given) one.merged = one.all;
          break;
        default:
          break;
      }
    }
  }
  std::map<std::pair<std::string, std::uint64_t>, CutFacts> by_name;
  for (const auto& [name, number] : numbers) {
    CutFacts& of = facts[number];
    const Given& its = given[number];
    if (!of.ended && its.merged < its.all) of.known = its.known;
    by_name[name] = std::move(of);
  }
  return by_name;
}

std::vector<std::optional<wire::CutEvent>> CutLogFacts::Events() const {
  std::vector<std::optional<wire::CutEvent>> events;
  std::uint64_t last = 0;
  for (const auto& [number, sample] : samples_) {
    if (number != last + 1) events.emplace_back();
    last = number;
    events.insert(events.end(), sample.events.begin(), sample.events.end());
  }
  return events;
}

CutSide::Ready CutSide::IsReadyFor(std::uint64_t pose_sequence) {
  if (facts_.session == 0) return Ready::kYes;
  if (!begun_) return why_.empty() ? Ready::kNotYet : Ready::kNever;
  const auto merge = facts_.merges.find(pose_sequence);
  if (merge == facts_.merges.end()) return Ready::kYes;
  const auto& [pose, first, count] = merge->second;
  while (!given_.empty() && given_.front().number < first) given_.pop_front();
  const bool is_there = given_.size() >= count && (count == 0 || given_.front().number == first) &&
                        (count == 0 || given_[count - 1].number == first + count - 1);
  if (is_there) return Ready::kYes;
  return first <= lost_ ? Ready::kNever : Ready::kNotYet;
}

void CutSide::Give(std::uint64_t pose_sequence, ServoLoop& loop) {
  loop.HoldCuts(facts_.IsHeld(pose_sequence));
  const auto merge = facts_.merges.find(pose_sequence);
  if (merge == facts_.merges.end()) return;
  for (std::uint32_t i = 0; i < merge->second.count && loop.wants_cuts(); ++i) {
    loop.GiveCut(given_.front());
    given_.pop_front();
  }
}

void CutSide::Take(ServoLoop& loop) {
  for (CutBlock block; loop.TakeCut(block);) {
    if (facts_.session != 0) published_.push_back(block);
  }
  for (CutMerge merge; loop.TakeMerge(merge);) {
  }
  for (std::uint64_t pose_sequence = 0; loop.TakeWhole(pose_sequence);) {
  }
}

CutSession* CutReplay::Find(std::uint32_t session) const {
  const auto it = sessions_.find(session);
  return it == sessions_.end() ? nullptr : it->second;
}

void CutReplay::Begin(const wire::CutEvent& event) {
  const bool has_all = event.count > 0;
  CutSession* const session = sessions_[event.session] = open_(event.session);
  if (session != nullptr && !union_) union_.emplace(session->solids());
  if (union_) union_->Join(event.session, has_all);
  if (session == nullptr) return;
  CutSide& side = session->side();
  side.begun_ = unknown_.empty();
  side.why_ = unknown_;
  if (side.begun_ && has_all) session->loop().cuts() = union_->cuts();
}

bool CutReplay::Take(const wire::CutEvent& event) {
  CutSession* const session = Find(event.session);
  if (session == nullptr) {
    if (event.count > 0) Lose("the session of another station that cut there is not recorded");
    return true;
  }
  std::deque<CutBlock>& published = session->side().published_;
  const bool is_there =
      event.other <= published.size() && event.count <= published.size() - event.other;
  if (!is_there) {
    if (!session->is_done()) return false;
    Lose(NotComputed(session->station()));
    return true;
  }
  published.erase(published.begin(), published.begin() + static_cast<std::ptrdiff_t>(event.other));
  for (std::uint32_t i = 0; i < event.count; ++i) {
    union_->Take(event.session, published.front());
    published.pop_front();
  }
  return true;
}

void CutReplay::Give(const wire::CutEvent& event) {
  CutSession* const session = Find(event.session);
  std::uint64_t& number = given_[event.session];
  CutBlock block;
  for (std::uint32_t i = 0; i < event.count; ++i) {
    if (!union_ || !union_->Give(event.session, block)) {
      Lose("the log of what burs cut contradicts itself");
      break;
    }
    block.number = number + i + 1;
    if (session != nullptr && unknown_.empty()) session->side().given_.push_back(block);
  }
  number += event.count;
  if (session == nullptr || unknown_.empty()) return;
  session->side().lost_ = number;
  session->side().why_ = unknown_;
}

bool CutReplay::End(const wire::CutEvent& event) {
  CutSession* const session = Find(event.session);
  if (session != nullptr && !session->is_done()) return false;
  const bool is_known = session != nullptr && session->last_pose() == event.pose_sequence;
  if (!is_known && event.count > 0) {
    Lose(session != nullptr ? NotComputed(session->station()) : kBefore);
  }
  CutBlock block;
  for (std::uint32_t i = 0; is_known && i < event.count; ++i) {
    if (!TakeChanged(session->loop().cuts(), block)) break;
    union_->Take(event.session, block);
  }
  if (union_) union_->Leave(event.session);
  sessions_.erase(event.session);
  over_[event.session] = true;
  return true;
}

bool CutReplay::Do(const wire::CutEvent& event) {
  switch (event.step) {
    case palpate_CUT_BEGUN:
      Begin(event);
      return true;
    case palpate_CUT_TAKEN:
      return Take(event);
    case palpate_CUT_GIVEN:
      Give(event);
      return true;
    case palpate_CUT_ENDED:
      return End(event);
    case palpate_CUT_WHOLE:
      if (union_) union_->MakeWhole();
      unknown_.clear();
      return true;
    case palpate_CUT_BOOKMARKED:
      if (union_) union_->SetBookmark();
      bookmark_unknown_ = unknown_;
      return true;
    case palpate_CUT_BACK:
      if (union_) union_->GoBack();
      unknown_ = bookmark_unknown_;
      return true;
    default:
      return true;
  }
}

bool CutReplay::Advance() {
  const std::size_t before = next_;
  for (; next_ < events_.size(); ++next_) {
    const auto& event = events_[next_];
    if (!event) {
      Lose(next_ == 0 ? kBefore : "a part of the log of what burs cut is not in the recording");
    } else if (!Do(*event)) {
      break;
    }
  }
  return next_ != before;
}

void CutReplay::GiveUp() {
  for (const auto& [number, session] : sessions_) {
    if (session == nullptr || session->is_done()) continue;
    CutSide& side = session->side();
    side.lost_ = std::numeric_limits<std::uint64_t>::max();
    if (side.why_.empty()) side.why_ = "what others cut by then is not in the recording";
  }
}

}  // namespace palpate
