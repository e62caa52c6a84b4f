#include "client/replayer/play/timeline.h"

#include <algorithm>

#include "common/dds/cdr_reader.h"
#include "common/dds/phase_name.h"
#include "common/dds/topics.h"
#include "common/files/bundle_hash.h"
#include "common/step_fault.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

/// Longest pause without a gap: tool states come 60 times a second, and plots bridge
/// shorter pauses.
constexpr std::int64_t kGap_ns = 500'000'000;
/// After a shorter release a tool is still in the same contact.
constexpr std::int64_t kFree_ns = 500'000'000;
/// Of faults in closer succession only the first gets a mark.
constexpr std::int64_t kFaultApart_ns = 1'000'000'000;
/// Faults that get no mark: a hand quicker than the tool, and a tool that waits.
constexpr std::uint32_t kUsualFaults = kFaultTargetFar | kFaultNotStarted;
/// The recorder receives the state from before its start within this time.
constexpr std::int64_t kOpening_ns = 200'000'000;
/// Least spacing of starts: in a file without chunks each message is a place, and a few suffice.
constexpr std::int64_t kStartsApart_ns = 50'000'000;

template <class T>
std::string StationIn(const RecordedSample& sample) {
  T value{};
  return sample.To(value) ? value.station : "";
}

std::string SceneIn(const RecordedSample& sample) {
  dds::Owned<wire::MovedState> moved;
  return sample.To(moved.value) ? moved.value.scene : "";
}

}  // namespace

bool Stays(RecordedType type) {
  return type == RecordedType::kSessionState || type == RecordedType::kSolidBlock ||
         type == RecordedType::kSceneWhole || type == RecordedType::kSceneBundle;
}

bool IsForViewers(RecordedType type) {
  return Stays(type) || type == RecordedType::kToolState || type == RecordedType::kMovedState ||
         type == RecordedType::kLoopStatistics || type == RecordedType::kStationStatistics;
}

Timeline::Source Timeline::SourceOf(const RecordedSample& sample) {
  switch (sample.type) {
    case RecordedType::kToolState:
      return {sample.type, StationIn<wire::ToolState>(sample)};
    case RecordedType::kMovedState:
      return {sample.type, SceneIn(sample)};
    case RecordedType::kLoopStatistics:
      return {sample.type, StationIn<wire::LoopStatistics>(sample)};
    default:
      return {sample.type, StationIn<wire::StationStatistics>(sample)};
  }
}

std::int64_t Timeline::TurnOf(const RecordedSample& sample, std::int64_t passed_ns) {
  return std::max(sample.log_time_ns, passed_ns);
}

void Timeline::Add(const RecordedSample& sample, const RecordingReader::Place& place) {
  const std::int64_t passed_ns = last_ns_;
  last_ns_ = TurnOf(sample, passed_ns);
  if (!any_) first_ns_ = opening_ns_ = last_ns_;
  // Shorter silences are never the reason of a gap.
  if (any_ && 2 * (last_ns_ - passed_ns) > kGap_ns) silences_.emplace_back(passed_ns, last_ns_);
  // Before the first sample nothing has passed.
  if (!any_) {
    starts_.push_back({-1, place});
  } else if (place != starts_.back().place &&
             passed_ns - starts_.back().passed_ns >= kStartsApart_ns) {
    starts_.push_back({passed_ns, place});
  }
  any_ = true;
  for_viewers_ += IsForViewers(sample.type);
  if (IsForViewers(sample.type) && !Stays(sample.type)) Hear(sample);
  switch (sample.type) {
    case RecordedType::kSessionState:
      return AddSession(sample);
    case RecordedType::kSolidBlock:
      return AddBlock(sample);
    case RecordedType::kSceneWhole:
      return AddWhole(sample);
    case RecordedType::kSceneBundle:
      return AddBundle(sample);
    case RecordedType::kToolState:
      return AddTool(sample);
    case RecordedType::kHapticPose:
      return AddPose(*sample.topic);
    default:
      return;
  }
}

void Timeline::Hear(const RecordedSample& sample) {
  const auto [it, is_new] = speeches_.try_emplace(SourceOf(sample));
  Speech& speech = it->second;
  if (!is_new && last_ns_ - speech.last_ns > kQuiet_ns) {
    speech.quiet.emplace_back(speech.last_ns, last_ns_);
  }
  speech.last_ns = last_ns_;
}

std::vector<std::pair<Timeline::Source, std::int64_t>> Timeline::QuietAt(
    std::int64_t time_ns) const {
  std::vector<std::pair<Source, std::int64_t>> sources;
  for (const auto& [source, speech] : speeches_) {
    // Finds the first pause that ends later; if none does, the time after the last sample remains.
    const auto quiet = std::ranges::upper_bound(speech.quiet, time_ns, {},
                                                &std::pair<std::int64_t, std::int64_t>::second);
    const std::int64_t from_ns = quiet == speech.quiet.end() ? speech.last_ns : quiet->first;
    if (time_ns - from_ns > kQuiet_ns) sources.emplace_back(source, from_ns);
  }
  return sources;
}

bool Timeline::Keep(const RecordedSample& sample, std::uint64_t server_run, const std::string& name,
                    std::uint64_t number, std::uint64_t place) {
  const Moment::Key key{sample.type, name, place};
  const auto found = last_.find(key);
  // A recorder repeats the present state at the beginning of each split.
  if (found != last_.end() && std::ranges::equal(states_[found->second].cdr, sample.cdr)) {
    return false;
  }
  last_[key] = states_.size();
  states_.push_back({sample.type,
                     last_ns_,
                     server_run,
                     name,
                     number,
                     place,
                     {sample.cdr.begin(), sample.cdr.end()}});
  return true;
}

Timeline::Station& Timeline::StationOf(const std::string& name) {
  const auto [it, is_new] = stations_.try_emplace(name);
  if (is_new) it->second.tool_ns = first_ns_;
  return it->second;
}

void Timeline::AddSession(const RecordedSample& sample) {
  wire::SessionState state{};
  if (!sample.To(state)) return;
  Keep(sample, state.server_run, state.station, 0);
  Station& station = StationOf(state.station);
  if (IsOver(state)) {
    // If another client of the same name is refused, the session continues.
    if (station.run != 0 && state.run != station.run) return;
    station.ended = station.over = state.reason[0] == '\0' ? "it ended" : state.reason;
    return;
  }
  station.run = state.run;
  station.over.clear();
  if (state.phase == palpate_SESSION_ACTIVE && begun_.emplace(state.station, state.run).second) {
    station.touches = station.has_touched = false;
    AddMark(palpate_REPLAY_SESSION, std::string(state.station) + " takes the " + state.tool);
  }
}

void Timeline::AddBlock(const RecordedSample& sample) {
  dds::Owned<wire::SolidBlock> owned;
  if (!sample.To(owned.value)) return;
  const wire::SolidBlock& block = owned.value;
  const std::uint64_t place = std::uint64_t{block.object_index} << 32 | block.block;
  Keep(sample, block.server_run, block.scene, block.change, place);
}

void Timeline::AddWhole(const RecordedSample& sample) {
  wire::SceneWhole whole{};
  if (!sample.To(whole)) return;
  const bool is_news = Keep(sample, whole.server_run, whole.scene, whole.last_change);
  if (is_news && last_ns_ - first_ns_ > kOpening_ns && whole.refusal[0] == '\0') {
    AddMark(
        palpate_REPLAY_WHOLE,
        whole.scene + std::string(whole.wish == palpate_WHOLE_BOOKMARK ? " is bookmarked"
                                  : whole.wish == palpate_WHOLE_BACK   ? " is back at its bookmark"
                                                                       : " is whole again"));
  }
}

void Timeline::AddBundle(const RecordedSample& sample) {
  dds::Owned<wire::SceneBundle> owned;
  if (!sample.To(owned.value)) return;
  const wire::SceneBundle& bundle = owned.value;
  // A seat's sample has no bundle.
  if (bundle.bundle._length > 0) {
    CheckBundleHash({bundle.bundle._buffer, bundle.bundle._length}, bundle.hash,
                    "the recording's scene " + Quoted(bundle.scene));
  }
  const bool is_first = !last_.contains({sample.type, bundle.scene, 0});
  if (is_first && last_ns_ - first_ns_ <= kOpening_ns) opening_ns_ = last_ns_;
  Keep(sample, bundle.server_run, bundle.scene, 0);
}

void Timeline::AddTool(const RecordedSample& sample) {
  wire::ToolState tool{};
  if (!sample.To(tool)) return;
  const std::string name = tool.station;
  Station& station = StationOf(name);
  CloseGap(name, station);
  station.any = true;
  Touch(name, station, tool.contacts > 0);
  Fail(name, station, tool.faults & ~kUsualFaults);
}

void Timeline::AddPose(const std::string& topic) {
  const auto [it, is_new] = station_of_.try_emplace(topic);
  if (is_new) {
    if (const auto session = dds::SessionOfTopic(topic)) it->second = session->first;
  }
  if (const auto station = stations_.find(it->second); station != stations_.end()) {
    ++station->second.poses;
  }
}

void Timeline::Touch(const std::string& name, Station& station, bool touches) {
  const bool was_free = !station.has_touched || last_ns_ - station.touched_ns > kFree_ns;
  if (touches && !station.touches && was_free) AddMark(palpate_REPLAY_CONTACT, name + " touches");
  if (touches) {
    station.has_touched = true;
    station.touched_ns = last_ns_;
  }
  station.touches = touches;
}

void Timeline::Fail(const std::string& name, Station& station, std::uint32_t faults) {
  const bool is_apart = !station.has_failed || last_ns_ - station.failed_ns > kFaultApart_ns;
  if ((faults & ~station.faults) != 0 && is_apart) {
    AddMark(palpate_REPLAY_FAULT, name + ": " + FaultWords(faults));
    station.has_failed = true;
    station.failed_ns = last_ns_;
  }
  station.faults = faults;
}

/// Adds a gap if the tool states since the station's last one are missing.
void Timeline::CloseGap(const std::string& name, Station& station) {
  if (last_ns_ - station.tool_ns > kGap_ns) {
    if (gaps_.size() < kMost) {
      gaps_.push_back({station.tool_ns, last_ns_, name, ReasonOf(station)});
    } else {
      ++left_out_;
    }
  }
  station.tool_ns = last_ns_;
  station.poses = 0;
  // A tool state may come after the report that its session has ended.
  station.ended = station.over;
}

std::string Timeline::ReasonOf(const Station& station) const {
  if (!station.ended.empty()) return "no session: " + station.ended;
  if (!station.any) return "no session yet";
  const std::int64_t length_ns = last_ns_ - station.tool_ns;
  const auto since = std::ranges::lower_bound(silences_, station.tool_ns, {},
                                              &std::pair<std::int64_t, std::int64_t>::first);
  for (auto silence = since; silence != silences_.end(); ++silence) {
    if (silence->second - silence->first > length_ns / 2) return "nothing at all was recorded";
  }
  // At least half of the loop's 1,000 poses per second.
  const bool has_poses =
      static_cast<double>(station.poses) > 0.5e-6 * static_cast<double>(length_ns);
  return has_poses ? "tool states were lost; the poses were recorded" : "the station was silent";
}

void Timeline::AddMark(palpate_ReplayMarkKind kind, std::string text) {
  if (marks_.size() < kMost) {
    marks_.push_back({last_ns_, kind, std::move(text)});
  } else {
    ++left_out_;
  }
}

void Timeline::Finish() {
  for (auto& [name, station] : stations_) {
    if (station.any) CloseGap(name, station);
  }
  std::ranges::stable_sort(gaps_, {}, &Gap::from_ns);
}

const Timeline::State* Timeline::Moment::WholeOf(const std::string& scene) const {
  const auto found = holds.find({RecordedType::kSceneWhole, scene, 0});
  return found == holds.end() ? nullptr : found->second;
}

Timeline::Moment Timeline::At(std::int64_t time_ns) const {
  Moment moment;
  std::set<std::uint64_t> former;
  for (const State& state : states_) {
    if (state.time_ns > time_ns) break;
    if (state.server_run != moment.server_run) {
      if (former.contains(state.server_run)) continue;
      former.insert(moment.server_run);
      moment = {state.server_run, {}};
    }
    const bool is_block = state.type == RecordedType::kSolidBlock;
    const State* const whole = is_block ? moment.WholeOf(state.name) : nullptr;
    if (whole != nullptr && state.number <= whole->number) continue;
    moment.holds[{state.type, state.name, state.place}] = &state;
    if (state.type != RecordedType::kSceneWhole) continue;
    // Drops the scene's changes that it undoes.
    auto held = moment.holds.lower_bound({RecordedType::kSolidBlock, state.name, 0});
    const auto end = moment.holds.upper_bound({RecordedType::kSolidBlock, state.name, UINT64_MAX});
    while (held != end) {
      held = held->second->number <= state.number ? moment.holds.erase(held) : std::next(held);
    }
  }
  return moment;
}

Timeline::Start Timeline::StartFor(std::int64_t time_ns) const {
  // The last start that has only earlier samples before it.
  const auto after = std::ranges::lower_bound(starts_, time_ns, {}, &Start::passed_ns);
  return after == starts_.begin() ? starts_.front() : *std::prev(after);
}

bool LeadsTo(const Timeline::Moment& published, const Timeline::Moment& wanted) {
  if (published.server_run != wanted.server_run) return false;
  return std::ranges::all_of(published.holds, [&](const auto& entry) {
    const Timeline::State& held = *entry.second;
    const Timeline::State* const whole = wanted.WholeOf(held.name);
    const std::uint64_t undone = whole == nullptr ? 0 : whole->number;
    if (held.type == RecordedType::kSceneWhole) return whole != nullptr && undone >= held.number;
    const bool is_block = held.type == RecordedType::kSolidBlock;
    if (is_block && held.number <= undone) return true;
    const auto later = wanted.holds.find(entry.first);
    if (later == wanted.holds.end()) return false;
    // A solid's block only loses material.
    return !is_block || later->second->number >= held.number;
  });
}

std::vector<const Timeline::State*> RestOf(const Timeline::Moment& wanted,
                                           const Timeline::Moment& published) {
  std::vector<const Timeline::State*> rest;
  for (const auto& [key, state] : wanted.holds) {
    const auto found = published.holds.find(key);
    if (found == published.holds.end() || found->second != state) rest.push_back(state);
  }
  // Pointers into one vector, so sorting gives the recording's order.
  std::ranges::sort(rest);
  return rest;
}

}  // namespace palpate
