#include "client/replayer/verify/verify.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
#include <deque>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "client/replayer/verify/cut_replay.h"
#include "common/dds/cdr_reader.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/files/bundle_hash.h"
#include "common/files/output.h"
#include "common/realtime/steady_clock.h"
#include "common/recording/recording_reader.h"
#include "common/recording/split_name.h"
#include "common/revision.h"
#include "common/text/hex16.h"
#include "common/text/quoted.h"
#include "scenes/catalogue.h"
#include "scenes/files/effect_file.h"
#include "scenes/files/scene_bundle.h"
#include "server/physics/scene_model.h"
#include "server/session/servo_loop.h"
#include "server/session/world.h"

namespace palpate {
namespace {

/// A wrench may precede its pose in the recording, by at most a burst of samples.
constexpr std::size_t kMostAhead = 1000;
/// Most answers of a hand that were under way to the recorder when it ended, without those of the
/// others between them.
constexpr std::size_t kMostUnder = 100;
/// Samples between two checks for Ctrl-C.
constexpr std::uint64_t kLook = 4096;
/// Sessions at the same time; a server has 32, and a recording may be of several servers.
constexpr std::size_t kMostAtOnce = 256;

enum class Number { kDouble, kUint64, kInt64, kUint32 };
struct Field {
  const char* name;
  std::size_t offset;
  std::size_t count, columns;  ///< columns: of a matrix; else 0
  Number number;
};
#define PALPATE_FIELD(name, count, columns, number) \
  { #name, offsetof(wire::Wrench, name), count, columns, Number::number }
// All fields but step_time_s.
constexpr Field kFields[] = {
    PALPATE_FIELD(pose_sequence, 1, 0, kUint64),
    PALPATE_FIELD(pose_time_ns, 1, 0, kInt64),
    PALPATE_FIELD(force_N, 3, 0, kDouble),
    PALPATE_FIELD(torque_Nm, 3, 0, kDouble),
    PALPATE_FIELD(graphic_position_m, 3, 0, kDouble),
    PALPATE_FIELD(graphic_orientation_wxyz, 4, 0, kDouble),
    PALPATE_FIELD(row, 36, 6, kDouble),
    PALPATE_FIELD(row_offset_m, 6, 0, kDouble),
    PALPATE_FIELD(row_force_N, 6, 0, kDouble),
    PALPATE_FIELD(passive_force_N, 3, 0, kDouble),
    PALPATE_FIELD(passive_torque_Nm, 3, 0, kDouble),
    PALPATE_FIELD(active_force_N, 3, 0, kDouble),
    PALPATE_FIELD(active_torque_Nm, 3, 0, kDouble),
    PALPATE_FIELD(region_m, 1, 0, kDouble),
    PALPATE_FIELD(region_rad, 1, 0, kDouble),
    PALPATE_FIELD(valid_s, 1, 0, kDouble),
    PALPATE_FIELD(step, 1, 0, kUint64),
    PALPATE_FIELD(hands, 1, 0, kUint32),
    PALPATE_FIELD(rows, 1, 0, kUint32),
    PALPATE_FIELD(contacts, 1, 0, kUint32),
    PALPATE_FIELD(faults, 1, 0, kUint32),
    PALPATE_FIELD(answer, 1, 0, kUint32),
    PALPATE_FIELD(pad, 1, 0, kUint32),
};
#undef PALPATE_FIELD

constexpr std::size_t SizeOf(Number number) {
  return number == Number::kUint32 ? 4 : 8;
}

constexpr std::size_t FieldBytes() {
  std::size_t sum = 0;
  for (const Field& field : kFields) sum += field.count * SizeOf(field.number);
  return sum;
}
static_assert(FieldBytes() + sizeof(wire::Wrench::step_time_s) == sizeof(wire::Wrench));

std::string ToText(const std::byte* at, Number number) {
  if (number == Number::kUint32) {
    std::uint32_t value;
    std::memcpy(&value, at, sizeof value);
    return fmt::format("{} (0x{:08x})", value, value);
  }
  std::uint64_t bits;
  std::memcpy(&bits, at, sizeof bits);
  switch (number) {
    case Number::kDouble:
      return fmt::format("{:.17g} (0x{:016x})", std::bit_cast<double>(bits), bits);
    case Number::kInt64:
      return fmt::format("{} (0x{:016x})", static_cast<std::int64_t>(bits), bits);
    default:
      return fmt::format("{} (0x{:016x})", bits, bits);
  }
}

/// The scenes of a recording: those that it holds, and for others the catalogue's, if their
/// hashes agree.
class Scenes {
 public:
  /// @param folder  that holds the recording.
  Scenes(const VerifyOptions& options, std::filesystem::path folder)
      : options_(options), folder_(std::move(folder)) {}

  /// Throws Error if the bundle does not match its hash.
  void AddBundle(const wire::SceneBundle& bundle) {
    const std::string hash = Hex16(bundle.hash);
    AddHash(bundle.scene, hash);
    if (bundle.bundle._length == 0) return;  // a seat: another sample has the bytes of that hash
    CheckBundleHash({bundle.bundle._buffer, bundle.bundle._length}, bundle.hash,
                    "the recording's scene " + Quoted(bundle.scene));
    bundles_[hash] = {bundle.bundle._buffer, bundle.bundle._buffer + bundle.bundle._length};
  }
  void AddHash(const std::string& scene, const std::string& hash) { hashes_[scene] = hash; }
  /// Takes the revision by which they were made.
  void SetRevision(const std::string& revision) { revision_ = revision; }

  std::string HashOf(const std::string& name) const {
    const auto found = hashes_.find(name);
    return found == hashes_.end() ? "" : found->second;
  }
  std::shared_ptr<const Scene> SceneOf(const std::string& name) { return Load(name).scene; }
  std::shared_ptr<const SceneObjects> ObjectsOf(const std::string& name) {
    return Load(name).objects;
  }
  /// Returns a new world of the scene's tools; null if hands do not meet there.
  std::shared_ptr<World> MakeWorld(const std::string& scene_name) {
    const Scene& scene = *Load(scene_name).scene;
    if (!scene.hands_meet) return nullptr;
    std::vector<const HapticModel*> models;
    for (const Body& tool : scene.tools) models.push_back(&ModelOf(scene_name, tool.name));
    return std::make_shared<World>(std::move(models));
  }
  std::size_t NumberOf(const std::string& scene_name, const std::string& tool_name) {
    const auto& tools = Load(scene_name).scene->tools;
    return static_cast<std::size_t>(std::ranges::find(tools, tool_name, &Body::name) -
                                    tools.begin());
  }
  const HapticModel& ModelOf(const std::string& scene_name, const std::string& tool_name) {
    Loaded& loaded = Load(scene_name);
    for (const Body& tool : loaded.scene->tools) {
      if (tool.name != tool_name) continue;
      auto& model = loaded.models[tool_name];
      if (!model) {
        model = std::make_unique<HapticModel>(MakeModel(*loaded.scene, tool, loaded.objects));
      }
      return *model;
    }
    throw Error("scene '" + scene_name + "' has no tool '" + tool_name +
                "': the recording is of another scene of that name; give it with --scene");
  }

 private:
  struct Loaded {
    std::shared_ptr<const Scene> scene;
    std::shared_ptr<const SceneObjects> objects;
    std::map<std::string, std::unique_ptr<HapticModel>> models;
  };

  /// Returns which of the effects are known to differ.
  std::string WhatEffects(const std::string& name, const std::vector<Effect>& of_scene) const {
    const auto bundle = bundles_.find(HashOf(name));
    if (bundle == bundles_.end()) return "";
    const auto words = [](const std::vector<Effect>& effects) {
      std::string text;
      for (const Effect& effect : effects) {
        text += fmt::format("{}{} (hash {}) of {}", text.empty() ? "" : ", ", effect.file,
                            Hex16(effect.hash), nlohmann::json(effect.values).dump());
      }
      return text.empty() ? std::string("none") : text;
    };
    const std::string its = words(of_scene);
    const std::string recorded = words(UnpackScene(bundle->second, name).effects);
    return its == recorded ? "" : ", which had the effects " + recorded + ", and it has " + its;
  }

  Loaded& Load(const std::string& name) {
    auto& loaded = loaded_[name];
    if (loaded) return *loaded;
    loaded = std::make_unique<Loaded>();
    if (const auto bundle = bundles_.find(HashOf(name));
        options_.scene.empty() && bundle != bundles_.end()) {
      const std::string source = "the recording's scene '" + name + "'";
      Scene scene = UnpackScene(bundle->second, source);
      LoadEffects(scene.effects, folder_, source);
      loaded->scene = std::make_shared<const Scene>(std::move(scene));
    } else {
      LoadOptions load;
      load.models_dir = options_.models_dir;
      loaded->scene = std::make_shared<const Scene>(
          LoadScene(options_.scene.empty() ? name : options_.scene, load));
      const std::string hash = SceneHash(*loaded->scene);
      const auto recorded = hashes_.find(name);
      if (recorded != hashes_.end() && recorded->second != hash) {
        throw Error("scene '" + name + "' (hash " + hash +
                    ") is not the one that was recorded (hash " + recorded->second + ")" +
                    WhatEffects(name, loaded->scene->effects) + "; " +
                    WhichBuild("scenes", revision_, kScenesRevision) +
                    ".  Give the recorded one with --scene, or record again");
      }
    }
    loaded->objects = MakeObjects(*loaded->scene);
    return *loaded;
  }

  const VerifyOptions& options_;
  const std::filesystem::path folder_;
  std::string revision_;
  std::map<std::string, std::string> hashes_;                 // by scene
  std::map<std::string, std::vector<std::uint8_t>> bundles_;  // by hash
  std::map<std::string, std::unique_ptr<Loaded>> loaded_;
};

/// The inputs of a session besides its poses.
struct SessionFacts {
  std::string station, scene, tool;
  std::uint64_t run = 0, server_run = 0;
  std::uint64_t ended = 0;                        ///< number of the sample that says so; 0: none
  std::map<std::uint64_t, Pose> starts;           ///< X_WG by the pose at which forces start
  std::optional<Pose> last_start;                 ///< the recorder ended before its pose was told
  std::map<std::uint64_t, std::uint64_t> wholes;  ///< LoopWhole.pose_sequence by its number
  CutFacts cuts{};
};

/// One session's loop, fed in the original order.
class SessionReplay : public CutSession {
 public:
  /// @param world  in which the tool meets others, and its number there; null: it is alone
  SessionReplay(const SessionFacts& facts, const HapticModel& model, std::int64_t began_ns,
                std::shared_ptr<World> world, std::size_t number)
      : facts_(facts),
        model_(model),
        world_(world ? world : std::make_shared<World>(std::vector{&model})),
        loop_(world_, world ? number : 0),
        side_(facts.cuts),
        began_ns_(began_ns) {
    verdict_.station = facts.station;
    verdict_.scene = facts.scene;
    verdict_.tool = facts.tool;
    verdict_.run = facts.run;
    next_whole_ = facts_.wholes.begin();
    next_start_ = facts_.starts.begin();
  }

  /// Makes the verdict keep the solids' cuts; call it before the first pose.
  void WantCut(SolidsCut cut) { verdict_.cut = std::move(cut); }
  /// Ends the session, as its initial state is not known.
  void BeginUnknown() {
    Stop(
        "what burs had cut before the recording began is not in it; make the scene whole, then "
        "record");
  }

  CutSide& side() override { return side_; }
  ServoLoop& loop() override { return loop_; }
  std::span<const CutSolid> solids() const override { return model_.solids(); }
  bool is_done() const override { return !verdict_.ends.empty() || (closed_ && is_computed_); }
  std::uint64_t last_pose() const override { return last_pose_; }
  /// Returns the number of answers that wait for steps of other hands.  If these never come, call
  /// EndWaiting.
  std::size_t waits_for_others() const { return waits_for_others_ ? waiting_.size() : 0; }
  /// Where hands meet: makes the step with which its hand left.
  void Leave() {
    loop_.Leave();
    has_left_ = true;
  }
  bool must_leave() const { return world_->is_shared() && facts_.ended != 0 && !has_left_; }
  /// @param cut_off  the recording may have ended before those steps
  void EndWaiting(bool cut_off) {
    if (cut_off && waiting_.size() <= kMostUnder) {
      ForgetAfter(last_pose_);
    } else {
      Stop(fmt::format("step {} of the scene's hands, another's, is not in the recording",
                       world_->steps() + 1));
    }
    Advance();
  }
  const std::string& station() const override { return facts_.station; }

  void Add(const wire::HapticPose& pose) {
    ++verdict_.poses;
    newest_pose_ = std::max(newest_pose_, pose.pose_sequence);
    if (verdict_.ends.empty()) poses_.emplace(pose.pose_sequence, pose);
    Advance();
  }
  void Add(const wire::Wrench& wrench, std::int64_t time_ns) {
    if (verdict_.recorded == 0) first_ns_ = time_ns;
    last_ns_ = time_ns;
    ++verdict_.recorded;
    if (verdict_.ends.empty()) waiting_.emplace_back(wrench, time_ns);
    Advance();
  }
  void AddBrokenWrench() {
    ++verdict_.recorded;
    ++verdict_.broken;
  }
  /// Ends the input.
  /// @param cut_off  the recording ends before the session.
  void Close(bool cut_off) {
    if (cut_off) ForgetAfter(newest_pose_);
    ForgetAfter(facts_.cuts.known);
    closed_ = true;
    Advance();
  }
  /// Computes as far as the input allows.
  void Advance() {
    while (!waiting_.empty() && verdict_.ends.empty()) {
      const auto& [wrench, time_ns] = waiting_.front();
      if (wrench.pose_sequence > facts_.cuts.known) return;  // Close removes it
      if (wrench.answer <= taken_) return Stop(fmt::format("answer {} is repeated", wrench.answer));
      if (!poses_.contains(wrench.pose_sequence)) {
        if (!closed_ && waiting_.size() < kMostAhead) return;
        return Stop(fmt::format("pose {} is not in the recording", wrench.pose_sequence));
      }
      const std::int64_t began_ns = SteadyNanoseconds();
      const bool is_done = Verify(wrench, time_ns);
      computed_ns_ += SteadyNanoseconds() - began_ns;
      if (!is_done) return;
      if (!waiting_.empty()) waiting_.pop_front();
    }
    if (!verdict_.ends.empty()) poses_.clear();
    if (closed_) is_computed_ = is_computed_ || FeedUnanswered();
  }
  /// Returns the verdict; call it when is_done().
  SessionVerdict Verdict() {
    if (verdict_.cut) {
      if (verdict_.cut->before.empty()) verdict_.cut->before = loop_.cuts();
      verdict_.cut->after = loop_.cuts();
    }
    verdict_.recorded_s = 1e-9 * static_cast<double>(last_ns_ - first_ns_);
    verdict_.computed_s = 1e-9 * static_cast<double>(computed_ns_);
    if (verdict_.recorded == 0) {
      verdict_.ends = fmt::format("it has {} poses, but no wrench", verdict_.poses);
    }
    return verdict_;
  }

 private:
  /// Drops the wrenches after a pose.  Poses, wrenches and merges reach the recorder separately,
  /// so it may have been cut off after a wrench but before its pose, or before a merge that the
  /// pose needs.
  void ForgetAfter(std::uint64_t pose_sequence) {
    while (!waiting_.empty() && waiting_.back().first.pose_sequence > pose_sequence) {
      waiting_.pop_back();
      --verdict_.recorded;
      ++verdict_.cut_off;
    }
  }

  void Stop(const std::string& why) {
    verdict_.ends = why;
    waiting_.clear();
    poses_.clear();
  }

  /// Feeds the poses before the end whose answers the recorder missed: other sessions may have
  /// received what the bur cut at them.  Returns false if it must wait.
  bool FeedUnanswered() {
    if (!facts_.cuts.ended) return true;
    const wire::CutEvent& ended = *facts_.cuts.ended;
    const auto end = poses_.upper_bound(ended.pose_sequence);
    const auto left = static_cast<std::uint64_t>(std::distance(poses_.begin(), end));
    if (left != ended.other - taken_) return true;
    while (poses_.begin() != end) {
      wire::Wrench ignored;
      if (!Feed(poses_.begin()->second, ignored)) return !verdict_.ends.empty();
      poses_.erase(poses_.begin());
    }
    return true;
  }

  /// Returns false if it must wait.
  bool Verify(const wire::Wrench& wrench, std::int64_t time_ns) {
    const auto end = poses_.find(wrench.pose_sequence);
    const std::uint32_t unseen = wrench.answer - taken_ - 1;
    const auto between = static_cast<std::uint64_t>(std::distance(poses_.begin(), end));
    // All the steps before this one must have been made, but for those of this session itself.
    waits_for_others_ = world_->is_shared() && wrench.step > world_->steps() + unseen + 1;
    if (waits_for_others_) return false;
    if (world_->is_shared() && wrench.step <= world_->steps() + unseen) {
      Stop(fmt::format("pose {} was step {} of the scene's hands, which have made {}",
                       wrench.pose_sequence, wrench.step, world_->steps()));
      return true;
    }
    if (unseen != 0 && unseen == between) {
      // The recording lacks their answers, but the loop received every one of these poses.
      while (poses_.begin() != end) {
        wire::Wrench ignored;
        if (!Feed(poses_.begin()->second, ignored)) return !verdict_.ends.empty();
        poses_.erase(poses_.begin());
      }
    } else if (unseen != 0) {
      Stop(taken_ == 0 ? fmt::format("the recording began after its loop: pose {} was its "
                                     "{}th, and {} of those before are recorded",
                                     wrench.pose_sequence, wrench.answer, between)
                       : fmt::format("before pose {} the loop has had {} poses whose answers "
                                     "are not in the recording, and {} poses are",
                                     wrench.pose_sequence, unseen, between));
      return true;
    }
    const bool had_force = std::exchange(has_force_, (wrench.faults & kFaultNotStarted) == 0);
    if (has_force_ && !had_force && facts_.last_start && next_start_ == facts_.starts.end()) {
      loop_.Start(*facts_.last_start);
    }
    wire::Wrench computed;
    if (!Feed(end->second, computed)) return !verdict_.ends.empty();
    // Poses that remain never reached the server.
    poses_.erase(poses_.begin(), std::next(end));
    if (auto difference = Difference(wrench, computed)) {
      if (verdict_.different++ == 0) {
        difference->time_s = 1e-9 * static_cast<double>(time_ns - began_ns_);
        verdict_.first = std::move(difference);
      }
    } else {
      ++verdict_.verified;
    }
    return true;
  }

  /// Returns false if the input it needs has not arrived yet, or never will; the verdict then
  /// says why.
  bool Feed(const wire::HapticPose& pose, wire::Wrench& answer) {
    if (const CutSide::Ready ready = side_.IsReadyFor(pose.pose_sequence);
        ready != CutSide::Ready::kYes) {
      if (ready == CutSide::Ready::kNever) Stop(std::string(side_.why()));
      return false;
    }
    if (verdict_.cut && taken_ == 0) verdict_.cut->before = loop_.cuts();
    if (next_start_ != facts_.starts.end() && pose.pose_sequence >= next_start_->first) {
      if (pose.pose_sequence != next_start_->first) {
        Stop(fmt::format("pose {}, with which forces began, is not in the recording",
                         next_start_->first));
        return false;
      }
      loop_.Start(next_start_->second);
      ++next_start_;
    }
    for (; next_whole_ != facts_.wholes.end() && next_whole_->second <= pose.pose_sequence;
         ++next_whole_) {
      loop_.MakeWhole();
      if (verdict_.cut) verdict_.cut->before = StepState(model_).cut.fields;
    }
    side_.Give(pose.pose_sequence, loop_);
    const bool is_answered = loop_.OnPose(pose, answer);
    side_.Take(loop_);
    if (!is_answered) {
      Stop(fmt::format("pose {} is repeated or out of order: the recording is inconsistent",
                       pose.pose_sequence));
      return false;
    }
    ++taken_;
    last_pose_ = pose.pose_sequence;
    return true;
  }

  const SessionFacts& facts_;
  const HapticModel& model_;
  const std::shared_ptr<World> world_;
  ServoLoop loop_;
  CutSide side_;
  bool closed_ = false, is_computed_ = false, waits_for_others_ = false, has_left_ = false;
  bool has_force_ = false;  // in the last recorded answer
  SessionVerdict verdict_;
  std::map<std::uint64_t, wire::HapticPose> poses_;  // not yet used
  std::deque<std::pair<wire::Wrench, std::int64_t>> waiting_;
  std::map<std::uint64_t, std::uint64_t>::const_iterator next_whole_;
  std::map<std::uint64_t, Pose>::const_iterator next_start_;
  std::uint64_t newest_pose_ = 0, last_pose_ = 0;
  std::uint32_t taken_ = 0;
  std::int64_t began_ns_, first_ns_ = 0, last_ns_ = 0, computed_ns_ = 0;
};

/// A scene in one run of a server.
using SceneRun = std::pair<std::string, std::uint64_t>;

/// The first pass: collects the sessions and the scenes.
/// @param last_samples  receives the number of the last sample of each loop topic.
/// @param empty_worlds  likewise the first step of each wrench topic after which no tool was there.
std::vector<std::unique_ptr<SessionFacts>> Gather(
    RecordingReader& reader, Scenes& scenes, std::int64_t& began_ns,
    std::map<std::string, std::uint64_t>& last_samples,
    std::map<std::string, std::uint64_t>& empty_worlds, std::map<SceneRun, CutLogFacts>& logs) {
  std::vector<std::unique_ptr<SessionFacts>> sessions;
  std::map<std::pair<std::string, std::uint64_t>, std::size_t> place;  // by station and run
  const auto facts_of = [&](const std::string& station, std::uint64_t run) -> SessionFacts& {
    const auto [it, is_new] = place.try_emplace({station, run}, sessions.size());
    if (!is_new) return *sessions[it->second];
    sessions.push_back(std::make_unique<SessionFacts>());
    sessions.back()->station = station;
    sessions.back()->run = run;
    return *sessions.back();
  };
  RecordedSample sample{};
  began_ns = 0;
  for (std::uint64_t number = 1; reader.Next(sample); ++number) {
    if (began_ns == 0) began_ns = sample.log_time_ns;
    if (sample.type == RecordedType::kHapticPose || sample.type == RecordedType::kWrench) {
      last_samples[*sample.topic] = number;
      wire::Wrench wrench;
      if (sample.To(wrench) && wrench.hands == 0) {
        empty_worlds.try_emplace(*sample.topic, wrench.step);
      }
      continue;
    }
    wire::SessionState state{};
    wire::LoopWhole whole{};
    dds::Owned<wire::SceneBundle> bundle;
    dds::Owned<wire::CutLog> log;
    if (sample.To(state)) {
      if (state.phase == palpate_SESSION_REFUSED) continue;
      SessionFacts& facts = facts_of(state.station, state.run);
      facts.scene = state.scene;
      facts.tool = state.tool;
      facts.server_run = state.server_run;
      if (state.phase == palpate_SESSION_ENDED && facts.ended == 0) facts.ended = number;
      const Pose start = wire::ToPose(state.start_position_m, state.start_orientation_wxyz);
      if (state.start_sequence != 0) {
        facts.starts[state.start_sequence] = start;
        facts.last_start.reset();
      } else if (state.phase == palpate_SESSION_ACTIVE) {
        facts.last_start = start;
      }
    } else if (sample.To(whole)) {
      facts_of(whole.station, whole.run).wholes[whole.number] = whole.pose_sequence;
    } else if (sample.To(bundle.value)) {
      scenes.AddBundle(bundle.value);
    } else if (sample.To(log.value)) {
      logs[{log.value.scene, log.value.server_run}].Add(log.value);
    }
  }
  for (const auto& [scene, log] : logs) {
    for (auto& [name, facts] : log.Sessions()) {
      const auto at = place.find(name);
      if (at != place.end()) sessions[at->second]->cuts = facts;
    }
  }
  for (const mcap::Metadata& metadata : reader.metadata()) {
    if (metadata.name == "palpate.scene" && metadata.values.contains("scene") &&
        metadata.values.contains("hash")) {
      scenes.AddHash(metadata.values.at("scene"), metadata.values.at("hash"));
    }
  }
  return sessions;
}

void Merge(const CutField& from, CutField& to) {
  const SparseField& field = from.field();
  for (std::size_t block = 0; block < field.lattice().block_count(); ++block) {
    const std::int32_t entry = field.entry(block);
    if (entry != SparseField::kBelow) to.Merge(block, entry < 0 ? nullptr : field.values(entry));
  }
}

/// The second pass: passes samples to their sessions, and cuts between sessions.
class Verifier {
 public:
  Verifier(const std::vector<std::string>& files, const VerifyOptions& options)
      : file_(files.front()),
        options_(options),
        reader_(files),
        scenes_(options, std::filesystem::path(file_).parent_path()) {
    std::map<std::string, std::uint64_t> empty_worlds;
    sessions_ = Gather(reader_, scenes_, began_ns_, last_samples_, empty_worlds, logs_);
    for (const auto& facts : sessions_) {
      if (facts->scene.empty()) continue;  // its states are in another split
      const std::string poses = dds::PoseTopic(facts->station, facts->run);
      Replayed& session = replayed_[poses];
      session.facts = facts.get();
      session.scene = {facts->scene, facts->server_run};
      by_scene_[session.scene].push_back(&session);
      for (const std::string& topic : {poses, dds::WrenchTopic(facts->station, facts->run)}) {
        by_topic_[topic] = &session;
        if (const auto empty = empty_worlds.find(topic); empty != empty_worlds.end()) {
          std::uint64_t& first =
              first_steps_.try_emplace(session.scene, empty->second).first->second;
          first = std::min(first, empty->second);
        }
        const auto last = last_samples_.find(topic);
        if (last == last_samples_.end()) continue;
        session.last_sample = std::max(session.last_sample, last->second);
      }
    }
    for (const auto& [scene, log] : logs_) {
      cuts_.try_emplace(scene, log.Events(), [this, scene = scene](std::uint32_t number) {
        return Find(scene, number);
      });
    }
  }

  Verification Run() {
    for (const mcap::Metadata& metadata : reader_.metadata()) {
      if (metadata.name != kRecordingRecord) continue;
      const auto value = [&](const char* key) {
        const auto found = metadata.values.find(key);
        return found == metadata.values.end() ? "" : found->second;
      };
      verification_.physics = value("physics");
      scenes_.SetRevision(value("scenes"));
    }
    verification_.problems = reader_.problems();
    verification_.damaged = reader_.damaged();
    const bool cut_off = !reader_.complete();
    reader_.Restart();
    RecordedSample sample{};
    for (std::uint64_t number = 1; reader_.Next(sample); ++number) {
      if (1e-9 * static_cast<double>(sample.log_time_ns - began_ns_) > options_.until_s) break;
      if (options_.stop != nullptr && number % kLook == 0 && options_.stop->stopped()) {
        throw Error(file_ + ": stopped before all of it was computed again");
      }
      const auto it = by_topic_.find(*sample.topic);
      if (it == by_topic_.end()) {
        HearOfScene(sample);
        continue;
      }
      Replayed& session = *it->second;
      Hear(sample, session);
      if (number == session.last_sample && session.replay) {
        session.is_closed = true;
        session.replay->Close(cut_off || session.facts->ended == 0);
      }
      Settle(session.scene);
    }
    for (auto& [topic, session] : replayed_) {
      if (!session.replay || session.is_closed) continue;
      session.is_closed = true;
      session.replay->Close(true);  // as far as recorded
    }
    Finish();
    if (options_.keep_left) KeepLeft();
    return std::move(verification_);
  }

 private:
  struct Replayed {
    const SessionFacts* facts;
    SceneRun scene{};
    std::uint64_t last_sample = 0;  // by its number in the recording
    // Exists from its first sample to its last, and while others need it: a loop takes a megabyte,
    // and there may be many sessions.
    std::unique_ptr<SessionReplay> replay{};
    bool is_closed = false;
    std::optional<SessionVerdict> verdict{};
  };

  SessionReplay& ReplayOf(Replayed& session) {
    if (session.replay) return *session.replay;
    if (++open_ > kMostAtOnce) {
      throw Error(file_ + ": has more than " + std::to_string(kMostAtOnce) +
                  " sessions at once, which no server has; verify it in parts");
    }
    const SessionFacts& facts = *session.facts;
    const HapticModel& model = scenes_.ModelOf(facts.scene, facts.tool);
    std::shared_ptr<World> world = WorldOf(session.scene);
    session.replay = std::make_unique<SessionReplay>(facts, model, began_ns_, std::move(world),
                                                     scenes_.NumberOf(facts.scene, facts.tool));
    const bool is_left_out =
        facts.cuts.session == 0 && logs_.contains(session.scene) && !model.solids().empty();
    if (is_left_out || unknown_.contains(session.scene)) session.replay->BeginUnknown();
    if (options_.whose == std::pair(facts.station, facts.run)) {
      session.replay->WantCut(
          {scenes_.SceneOf(facts.scene), scenes_.ObjectsOf(facts.scene), {}, {}});
    }
    return *session.replay;
  }

  /// Returns the world of a scene in which hands meet, from where the recording has it all; else
  /// null.
  std::shared_ptr<World> WorldOf(const SceneRun& scene) {
    const auto [world, is_new] = worlds_.try_emplace(scene);
    if (!is_new) return world->second;
    world->second = scenes_.MakeWorld(scene.first);
    if (const auto first = first_steps_.find(scene); world->second && first != first_steps_.end()) {
      world->second->BeginAt(first->second - 1);
    }
    return world->second;
  }

  /// Returns a session by its number in the cut log; null if it is not recorded.
  CutSession* Find(const SceneRun& scene, std::uint32_t number) {
    for (Replayed* const session : by_scene_[scene]) {
      if (session->facts->cuts.session != number || session->last_sample == 0) continue;
      return &ReplayOf(*session);
    }
    return nullptr;
  }

  void Hear(const RecordedSample& sample, Replayed& session) {
    wire::HapticPose pose;
    wire::Wrench wrench;
    if (sample.To(pose)) {
      ReplayOf(session).Add(pose);
    } else if (sample.To(wrench)) {
      ReplayOf(session).Add(wrench, sample.log_time_ns);
    } else if (sample.type == RecordedType::kWrench) {
      ReplayOf(session).AddBrokenWrench();
    }
  }

  /// Takes a sample that belongs to no known session.
  void HearOfScene(const RecordedSample& sample) {
    if (sample.type == RecordedType::kWrench) ++stray_[*sample.topic];
    wire::SceneWhole whole{};
    dds::Owned<wire::SolidBlock> block;
    if (sample.To(whole) && whole.refusal[0] == '\0') {
      const SceneRun scene(whole.scene, whole.server_run);
      undone_[scene] = whole.last_change;
      unknown_.erase(scene);
      left_.erase(scene);
      const bool runs = std::ranges::any_of(by_scene_[scene],
                                            [](const Replayed* s) { return s->replay != nullptr; });
      if (runs && restored_.insert(whole.request).second) {
        verification_.restorations.push_back(
            {whole.by, whole.wish, 1e-9 * static_cast<double>(sample.log_time_ns - began_ns_)});
      }
    } else if (sample.To(block.value)) {
      const SceneRun scene(block.value.scene, block.value.server_run);
      // Cut by a session that was not recorded.  A split repeats blocks, including undone ones.
      const bool is_heard =
          logs_.contains(scene) || std::ranges::any_of(by_scene_[scene], [](const Replayed* s) {
            return s->replay || s->verdict;
          });
      if (!is_heard && block.value.change > undone_[scene]) unknown_.insert(scene);
    }
  }

  /// Exchanges cuts between a scene's sessions until none can continue, and ends finished sessions.
  /// @param all  nothing more comes
  void Settle(const SceneRun& scene, bool all = false) {
    const auto exchange = cuts_.find(scene);
    const std::vector<Replayed*>& of = by_scene_[scene];
    AdvanceTogether(of, all);
    while (exchange != cuts_.end() && exchange->second.Advance()) {
      for (const Replayed* session : of) {
        if (session->replay) session->replay->Advance();
      }
    }
    for (Replayed* const session : of) {
      if (!session->replay || !session->is_closed || !session->replay->is_done()) continue;
      if (!session->verdict) TakeVerdict(*session);
      const std::uint32_t number = session->facts->cuts.session;
      if (number != 0 && !exchange->second.IsOver(number)) continue;
      if (session->replay->must_leave()) continue;
      session->replay.reset();
      --open_;
    }
  }

  /// Lets the hands of a world make their steps in turn, as far as they can.
  /// @param all  nothing more comes
  static void AdvanceTogether(const std::vector<Replayed*>& of, bool all) {
    for (bool any = true; any;) {
      any = false;
      std::size_t most = 0;
      Replayed* next = nullptr;  // of those that have left, whose session ended first
      for (Replayed* const session : of) {
        if (!session->replay) continue;
        const std::uint64_t before = session->replay->last_pose();
        if (session->replay->waits_for_others() > 0) session->replay->Advance();
        any |= session->replay->last_pose() != before;
        most = std::max(most, session->replay->waits_for_others());
        if (session->is_closed && session->replay->is_done() && session->replay->must_leave() &&
            (!next || session->facts->ended < next->facts->ended)) {
          next = session;
        }
      }
      // A leave is in no sample.  It is the missing step if no sample with that step comes in time.
      if (!any && next != nullptr && (most > kMostUnder || (all && most > 0))) {
        next->replay->Leave();
        any = true;
      }
    }
  }

  /// Takes the verdict, and merges the session's cuts into what is left of the scene.
  void TakeVerdict(Replayed& session) {
    session.verdict = session.replay->Verdict();
    session.verdict->scene_hash = scenes_.HashOf(session.facts->scene);
    const std::vector<CutField>& cuts = session.replay->loop().cuts();
    if (!options_.keep_left || cuts.empty()) return;
    const auto [left, is_first] = left_.try_emplace(session.scene, cuts);
    for (std::size_t i = 0; !is_first && i < cuts.size(); ++i) Merge(cuts[i], left->second[i]);
  }

  /// Keeps the remaining solids of all scenes in which a recorded session could cut.
  void KeepLeft() {
    for (const auto& [scene, of] : by_scene_) {
      if (std::ranges::none_of(of, [](const Replayed* s) { return s->verdict.has_value(); }))
        continue;
      const HapticModel& model = scenes_.ModelOf(scene.first, of.front()->facts->tool);
      std::vector<CutField> whole = StepState(model).cut.fields;
      if (whole.empty()) continue;
      const auto left = left_.find(scene);
      std::vector<CutField> after = left == left_.end() ? whole : std::move(left->second);
      verification_.left.push_back({scenes_.SceneOf(scene.first), scenes_.ObjectsOf(scene.first),
                                    std::move(whole), std::move(after)});
    }
  }

  void Finish() {
    for (const auto& [scene, of] : by_scene_) {
      Settle(scene, true);
      if (const auto exchange = cuts_.find(scene); exchange != cuts_.end()) {
        exchange->second.GiveUp();
      }
      // A session whose end is not recorded may have made the missing steps after the last ones.
      const bool cut_off =
          std::ranges::any_of(of, [](const Replayed* s) { return s->facts->ended == 0; });
      for (Replayed* const session : of) {
        if (!session->replay || session->verdict) continue;
        session->replay->Advance();
        if (session->replay->waits_for_others()) session->replay->EndWaiting(cut_off);
        TakeVerdict(*session);
      }
    }
    for (const auto& [topic, session] : replayed_) {
      // A session without any sample has nothing to verify.
      const bool any =
          session.verdict &&
          session.verdict->poses + session.verdict->recorded + session.verdict->cut_off > 0;
      if (any) verification_.sessions.push_back(*session.verdict);
    }
    for (const auto& [topic, count] : stray_) {
      SessionVerdict verdict;
      verdict.station = topic;
      verdict.recorded = count;
      verdict.ends = "its session's state, which tells scene and start, is not in the recording";
      verification_.sessions.push_back(verdict);
    }
  }

  const std::string file_;
  const VerifyOptions& options_;
  RecordingReader reader_;
  Scenes scenes_;
  Verification verification_;
  std::int64_t began_ns_ = 0;
  std::map<std::string, std::uint64_t> last_samples_;
  std::map<SceneRun, CutLogFacts> logs_;
  std::vector<std::unique_ptr<SessionFacts>> sessions_;
  std::map<std::string, Replayed> replayed_;   // by its pose topic
  std::map<std::string, Replayed*> by_topic_;  // both topics of a session
  std::map<SceneRun, std::vector<Replayed*>> by_scene_;
  std::map<SceneRun, CutReplay> cuts_;
  std::map<SceneRun, std::uint64_t> first_steps_;  // at which no tool was there
  std::map<SceneRun, std::shared_ptr<World>> worlds_;
  std::set<std::uint64_t> restored_;                // requests that Verification::restorations has
  std::set<SceneRun> unknown_;                      // solids cut by an unrecorded session
  std::map<SceneRun, std::uint64_t> undone_;        // the last undone change
  std::map<SceneRun, std::vector<CutField>> left_;  // merged from ended sessions
  std::map<std::string, std::uint64_t> stray_;      // wrenches of sessions whose states are missing
  std::size_t open_ = 0;
};

}  // namespace

std::optional<WrenchDifference> Difference(const wire::Wrench& recorded,
                                           const wire::Wrench& computed) {
  const auto* a = reinterpret_cast<const std::byte*>(&recorded);
  const auto* b = reinterpret_cast<const std::byte*>(&computed);
  for (const Field& field : kFields) {
    const std::size_t size = SizeOf(field.number);
    for (std::size_t i = 0; i < field.count; ++i) {
      const std::size_t at = field.offset + i * size;
      if (std::memcmp(a + at, b + at, size) == 0) continue;
      WrenchDifference difference;
      difference.pose_sequence = recorded.pose_sequence;
      difference.field = field.name;
      if (field.columns > 0) difference.field += fmt::format("[{}]", i / field.columns);
      if (field.count > 1) {
        difference.field += fmt::format("[{}]", field.columns > 0 ? i % field.columns : i);
      }
      difference.recorded = ToText(a + at, field.number);
      difference.computed = ToText(b + at, field.number);
      return difference;
    }
  }
  return std::nullopt;
}

bool Verification::good() const {
  return !sessions.empty() && !damaged &&
         std::ranges::all_of(sessions, [](const SessionVerdict& v) { return v.good(); });
}

bool Verification::differs() const {
  return std::ranges::any_of(sessions, [](const SessionVerdict& v) { return v.different > 0; });
}

std::string WhichBuild(std::string_view kind, const std::string& recorded, const std::string& own) {
  if (recorded.empty()) {
    return fmt::format("recorded by a build that did not tell its {} revision; this is {}", kind,
                       own);
  }
  if (recorded == own) {
    return fmt::format(
        "recorded by the same {} revision, {}: two builds of it must agree, so report this", kind,
        own);
  }
  return fmt::format(
      "recorded by {} {}, this is {}: their bits may differ.  'deploy/revision {}' in a checkout "
      "names the commit to build",
      kind, Printable(recorded), own, Printable(recorded));
}

Verification Verify(const std::vector<std::string>& files, const VerifyOptions& options) {
  return Verifier(files, options).Run();
}

std::string ToText(const Verification& verification) {
  std::string text;
  for (const SessionVerdict& v : verification.sessions) {
    const std::uint64_t computed = v.verified + v.different;
    text += fmt::format(
        "{}: station {}{}: {} of {} wrenches verified, bit for bit",
        v.good() ? "same" : "NOT VERIFIED", Printable(v.station),
        v.scene.empty() ? "" : fmt::format(" with {} in {}", Printable(v.tool), Printable(v.scene)),
        v.verified, v.recorded);
    if (computed > 0 && v.computed_s > 0.0) {
      text += fmt::format("; {:.2f} s in {:.3f} s, {:.0f} x real time", v.recorded_s, v.computed_s,
                          v.recorded_s / v.computed_s);
    }
    text += "\n";
    if (v.first) {
      text += fmt::format(
          "  {} differ; the first answers pose {}, {:.3f} s after the beginning, field {}:\n"
          "    recorded {}\n    computed {}\n",
          v.different, v.first->pose_sequence, v.first->time_s, v.first->field, v.first->recorded,
          v.first->computed);
    }
    if (v.cut_off > 0) {
      text += fmt::format("  {} more at its end answer poses after the end of the recording\n",
                          v.cut_off);
    }
    if (v.broken > 0) text += fmt::format("  {} of them are damaged\n", v.broken);
    if (!v.ends.empty()) {
      text += fmt::format("  {} could not be computed: {}\n", v.recorded - computed - v.broken,
                          Printable(v.ends));
    }
  }
  if (verification.differs()) {
    text += "  " + WhichBuild("physics", verification.physics, kPhysicsRevision) + "\n";
  }
  if (verification.damaged) text += "NOT VERIFIED: a file has changed since it was written\n";
  if (verification.sessions.empty()) text += "NOT VERIFIED: there is no wrench in the recording\n";
  for (const std::string& problem : verification.problems) text += "  " + Printable(problem) + "\n";
  return text;
}

void WriteJson(const Verification& verification, const std::string& file) {
  nlohmann::ordered_json json{{"good", verification.good()},
                              {"damaged", verification.damaged},
                              {"recorded_physics", verification.physics},
                              {"physics", kPhysicsRevision},
                              {"problems", verification.problems},
                              {"sessions", nlohmann::ordered_json::array()}};
  for (const SessionVerdict& v : verification.sessions) {
    nlohmann::ordered_json session{
        {"station", v.station}, {"scene", v.scene},           {"tool", v.tool},
        {"poses", v.poses},     {"recorded", v.recorded},     {"broken", v.broken},
        {"cut_off", v.cut_off}, {"verified", v.verified},     {"different", v.different},
        {"ends", v.ends},       {"recorded_s", v.recorded_s}, {"computed_s", v.computed_s}};
    if (v.first) {
      session["first"] = {{"pose_sequence", v.first->pose_sequence},
                          {"time_s", v.first->time_s},
                          {"field", v.first->field},
                          {"recorded", v.first->recorded},
                          {"computed", v.first->computed}};
    }
    json["sessions"].push_back(session);
  }
  WriteOutput("--json", file,
              json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

}  // namespace palpate
