#include "server/session/cut_exchange.h"

#include <utility>

namespace palpate {

void CutExchange::Log(wire::CutStep step, std::uint32_t session, std::uint64_t count,
                      std::uint64_t pose_sequence, std::uint64_t other) {
  // A sample holds the name of only one session that begins.
  if (log_.empty() || step == palpate_CUT_BEGUN || log_.back().sample.begun_station[0] != '\0') {
    wire::CutLog& sample = log_.emplace_back().sample;
    sample.number = ++logged_;
    sample.slot = static_cast<std::uint32_t>(sample.number % kSlots);
  }
  std::vector<wire::CutEvent>& events = log_.back().events;
  if (step == palpate_CUT_TAKEN && other == 0 && !events.empty() &&
      events.back().step == palpate_CUT_TAKEN && events.back().session == session) {
    events.back().count += static_cast<std::uint32_t>(count);
    return;
  }
  wire::CutEvent& event = events.emplace_back();
  event = {};
  event.step = step;
  event.session = session;
  event.count = static_cast<std::uint32_t>(count);
  event.pose_sequence = pose_sequence;
  event.other = other;
}

void CutExchange::Begin(Session& session) {
  if (session.loop().cuts().empty()) return;
  // A loop that has yet to make all whole would lose the blocks; they are given afterwards.
  const bool is_ready = session.loop().made_whole();
  session.Begin(union_.cuts(), is_ready);
  const std::uint32_t number = ++begun_;
  numbers_[&session] = number;
  union_.Join(number, is_ready);
  Log(palpate_CUT_BEGUN, number, is_ready ? 1 : 0);
  wire::FromText(session.station(), log_.back().sample.begun_station);
  log_.back().sample.begun_run = session.run();
}

void CutExchange::Take(Session& session, const Changed& changed) {
  const auto it = numbers_.find(&session);
  if (it == numbers_.end()) return;
  ServoLoop& loop = session.loop();
  std::uint64_t taken = 0, gone = 0;
  for (CutBlock block; loop.TakeCut(block);) {
    if (block.held_from != 0) {
      Log(palpate_CUT_HELD, it->second, 0, block.held_from, block.pose_sequence);
    }
    if (!loop.is_current(block)) {
      ++gone;
      continue;
    }
    ++taken;
    if (union_.Take(it->second, block)) changed(block.solid, block.block);
  }
  if (taken + gone > 0) Log(palpate_CUT_TAKEN, it->second, taken, 0, gone);
  for (CutMerge merge; loop.TakeMerge(merge);) {
    Log(palpate_CUT_MERGED, it->second, merge.count, merge.pose_sequence, merge.number);
  }
}

void CutExchange::Give(Session& session) {
  const auto it = numbers_.find(&session);
  if (it == numbers_.end()) return;
  ServoLoop& loop = session.loop();
  std::uint64_t given = 0;
  for (CutBlock block; loop.wants_cuts() && union_.Give(it->second, block); ++given) {
    loop.GiveCut(block);
  }
  if (given > 0) {
    Log(palpate_CUT_GIVEN, it->second, given, session.snapshot().pose_sequence);
  }
}

void CutExchange::End(Session& session, const Changed& changed) {
  Take(session, changed);
  const auto it = numbers_.find(&session);
  if (it == numbers_.end()) return;
  ServoLoop& loop = session.loop();
  if (loop.held_from() != 0) {
    Log(palpate_CUT_HELD, it->second, 0, loop.held_from(), loop.last_sequence() + 1);
  }
  std::uint64_t left = 0;
  // A session whose loop has not made the scene whole contributes nothing.
  if (loop.made_whole()) {
    for (CutBlock block; TakeChanged(loop.cuts(), block); ++left) {
      if (union_.Take(it->second, block)) changed(block.solid, block.block);
    }
  }
  Log(palpate_CUT_ENDED, it->second, left, loop.last_sequence(), loop.answers());
  union_.Leave(it->second);
  numbers_.erase(it);
}

void CutExchange::MakeWhole() {
  union_.MakeWhole();
  Log(palpate_CUT_WHOLE, 0);
}

void CutExchange::SetBookmark() {
  union_.SetBookmark();
  Log(palpate_CUT_BOOKMARKED, 0);
}

void CutExchange::GoBack() {
  union_.GoBack();
  Log(palpate_CUT_BACK, 0);
}

bool CutExchange::has_all(Session& session) const {
  const auto it = numbers_.find(&session);
  return it == numbers_.end() || (union_.has_all(it->second) && session.loop().has_merged());
}

std::vector<CutLogNews> CutExchange::TakeLog(std::int64_t now_ns) {
  const bool alone =
      log_.size() == 1 && log_[0].events.size() == 1 && log_[0].events[0].step == palpate_CUT_TAKEN;
  if (log_.empty() || (alone && now_ns - published_ns_ < kTakenAlone_ns)) return {};
  published_ns_ = now_ns;
  return std::exchange(log_, {});
}

}  // namespace palpate
