#include "server/session/session_table.h"

#include <algorithm>
#include <array>
#include <utility>

#include "common/dds/topics.h"

namespace palpate {
namespace {

void AddName(std::string& list, const std::string& name) {
  if (!list.empty()) list += ", ";
  list += name;
}

/// The device that palpate-station calls so; its hand feels nothing.
constexpr const char* kMouse = "mouse";

dds::LeaveKey ToSeal(const wire::SessionRequest& request) {
  return std::to_array(request.leave_seal);
}

/// Both values are public: whoever repeats them keeps the place for the other, and gains nothing.
bool IsSameRun(const wire::SessionRequest& one, const wire::SessionRequest& other) {
  return one.run == other.run && ToSeal(one) == ToSeal(other);
}

}  // namespace

SessionTable::SessionTable(std::vector<std::shared_ptr<const ServedTool>> tools,
                           std::uint64_t server_run, bool admit_by_hand)
    : tools_(std::move(tools)), server_run_(server_run), admit_by_hand_(admit_by_hand) {
  // Some of a scene's tools may cut nothing; the solids are the same for those that do.
  for (const auto& tool : tools_) {
    const auto solids = tool->model.solids();
    if (!solids.empty()) scenes_.try_emplace(tool->scene, tool->scene, solids, server_run_);
  }
  std::map<std::string, std::vector<const HapticModel*>> meet;
  for (const auto& tool : tools_) {
    if (tool->hands_meet) meet[tool->scene].push_back(&tool->model);
  }
  for (auto& [scene, models] : meet) worlds_[scene] = std::make_shared<World>(std::move(models));
}

void SessionTable::Request(const wire::SessionRequest& request, std::int64_t now_ns) {
  if (!dds::IsStationName(request.station)) {
    return Refuse(request,
                  std::string("'") + request.station +
                      "' is not a valid name of a station; give 1 to 32 letters, digits or '_'",
                  now_ns);
  }
  if (request.leave) return Leave(request);
  const auto successor = waiting_.find(request.station);
  const auto held = held_.find(request.station);
  const auto session = sessions_.find(request.station);
  if (held != held_.end() && IsSameRun(held->second.request, request)) {
    held->second.since_ns = now_ns;  // it still waits, and has been told so
  } else if (session != sessions_.end() && session->second->run() == request.run) {
    session->second->HearAsking(now_ns);
    if (refusals_.Take(now_ns)) {
      Publish(*session->second);  // a repeated request gets the same answer again
    } else {
      ++untold_;
    }
  } else if (successor != waiting_.end()) {
    // The first to ask has the place; a third asks again once that one is answered.
    if (!IsSameRun(successor->second.request, request)) ++untold_;
  } else if (held != held_.end() || session != sessions_.end()) {
    waiting_[request.station] = {request, now_ns};
  } else if (MayBegin(request, now_ns)) {
    Admit(request, now_ns);
  }
}

void SessionTable::Leave(const wire::SessionRequest& request) {
  for (auto* const requests : {&waiting_, &held_}) {
    const auto asked = requests->find(request.station);
    if (asked == requests->end()) continue;
    const wire::SessionRequest& before = asked->second.request;
    if (before.run == request.run && dds::Opens(request.leave_key, ToSeal(before))) {
      requests->erase(asked);
    }
  }
  const auto session = sessions_.find(request.station);
  if (session != sessions_.end() && session->second->run() == request.run &&
      dds::Opens(request.leave_key, session->second->leave_seal())) {
    session->second->Leave();
  }
}

bool SessionTable::MayBegin(const wire::SessionRequest& request, std::int64_t now_ns) {
  const auto standing = standings_.find(request.station);
  const bool known = standing != standings_.end();
  if (known && standing->second.admitted) return true;
  const bool taken_back = known && !standing->second.taken_back_by.empty();
  if (!admit_by_hand_ && !taken_back) return true;
  if (held_.size() >= kMaxStations) {
    Refuse(request, "too many stations are waiting to be admitted; try again later", now_ns);
    return false;
  }
  if (!refusals_.Take(now_ns)) {
    ++untold_;
    return false;
  }
  held_[request.station] = {request, now_ns};
  TellHeld(request);
  return false;
}

void SessionTable::TellHeld(const wire::SessionRequest& request) {
  const auto standing = standings_.find(request.station);
  const bool taken_back = standing != standings_.end() && !standing->second.taken_back_by.empty();
  changes_.push_back(AnswerTo(
      request, palpate_SESSION_HELD,
      taken_back ? "taken back by " + standing->second.taken_back_by + ", who may admit it again"
                 : "waits to be admitted by a person at the server's gateway"));
}

bool SessionTable::Operate(const wire::OperateRequest& request, std::int64_t now_ns) {
  if (request.server_run != server_run_ || !requests_heard_.IsNew(request.request)) return false;
  const auto session = sessions_.find(request.station);
  const auto held = held_.find(request.station);
  const bool here = session != sessions_.end() || held != held_.end();
  if (!here && !standings_.contains(request.station)) return false;
  if (standings_.size() >= kMostNames && !standings_.contains(request.station)) return false;
  Standing& standing = standings_[request.station];
  switch (request.wish) {
    case palpate_OPERATE_ADMIT:
      standing.admitted = true;
      standing.taken_back_by.clear();
      if (held != held_.end()) {
        const wire::SessionRequest asked = held->second.request;
        held_.erase(held);
        Admit(asked, now_ns);
      }
      break;
    case palpate_OPERATE_TAKE_BACK:
      standing.admitted = false;
      standing.taken_back_by = request.by[0] == '\0' ? "somebody" : request.by;
      if (session != sessions_.end())
        session->second->End("taken back by " + standing.taken_back_by);
      if (held != held_.end()) {
        const wire::SessionRequest asked = held->second.request;
        held_.erase(held);
        Refuse(asked, "not admitted by " + standing.taken_back_by, now_ns);
      }
      break;
    case palpate_OPERATE_MUTE:
    case palpate_OPERATE_UNMUTE:
      standing.muted = request.wish == palpate_OPERATE_MUTE;
      if (session != sessions_.end()) Publish(*session->second);
      break;
  }
  return true;
}

void SessionTable::Update(std::int64_t now_ns) {
  now_ns_ = now_ns;
  for (const auto& [station, session] : sessions_) {
    CutExchange* const cuts = CutsOf(*session);
    if (session->start_is_held() && cuts->has_all(*session)) session->HoldStart(false);
  }
  // One start pose at a time, in turn, because everything else in this thread waits for it.
  const Session* next = nullptr;
  for (const auto& [station, session] : sessions_) {
    if (session->wants_start(now_ns) && (!next || session->tried_ns() < next->tried_ns())) {
      next = session.get();
    }
  }
  for (auto it = sessions_.begin(); it != sessions_.end();) {
    Session& session = *it->second;
    if (session.Update(now_ns, !next || &session == next) || session.ended()) Publish(session);
    if (const auto scene = scenes_.find(session.tool().scene); scene != scenes_.end()) {
      scene->second.cuts().Take(session, TakerOf(scene->second, now_ns));
      for (wire::LoopWhole whole{}; session.TakeWhole(whole);) loop_wholes_.push_back(whole);
    }
    // A session without a pose has left the scene as it was.
    if (session.ended() && session.has_heard()) {
      cut_off_[session.tool().scene] = session.left() ? "" : session.station();
    }
    if (session.ended()) ending_.push_back(it->second);
    it = session.ended() ? sessions_.erase(it) : std::next(it);
  }
  for (const auto& [station, session] : sessions_) {
    if (CutExchange* const cuts = CutsOf(*session)) cuts->Give(*session);
  }
  ForgetHeld(now_ns);
  for (auto it = waiting_.begin(); it != waiting_.end();) {
    const Waiting waiting = it->second;
    const Name name = StateOfName(waiting, now_ns);
    if (name == Name::kUndecided) {
      ++it;
      continue;
    }
    it = waiting_.erase(it);
    if (name == Name::kFree) {
      if (MayBegin(waiting.request, now_ns)) Admit(waiting.request, now_ns);
    } else {
      RefuseSuccessor(waiting.request, now_ns);
    }
  }
}

SessionTable::Name SessionTable::StateOfName(const Waiting& successor, std::int64_t now_ns) const {
  if (const auto session = sessions_.find(successor.request.station); session != sessions_.end()) {
    // A station without a pose yet has the time for its first one.
    const std::int64_t patience_ns = kTakeOverPauses * session->second->silence_ns() +
                                     (session->second->has_heard() ? 0 : Session::kFirstPose_ns);
    return now_ns - successor.since_ns > patience_ns ? Name::kTaken : Name::kUndecided;
  }
  if (const auto held = held_.find(successor.request.station); held != held_.end()) {
    // It has asked since, so it is alive.
    return held->second.since_ns > successor.since_ns ? Name::kTaken : Name::kUndecided;
  }
  return Name::kFree;
}

void SessionTable::RefuseSuccessor(const wire::SessionRequest& request, std::int64_t now_ns) {
  const auto session = sessions_.find(request.station);
  const auto held = held_.find(request.station);
  Refuse(request,
         std::string("a station named '") + request.station +
             (session != sessions_.end() ? "' is connected and sends poses; give another --id"
                                         : "' waits to be admitted; give another --id"),
         now_ns);
  // Otherwise one that comes later would take the refusal for the state of the one
  // who has the name.
  if (session != sessions_.end()) Publish(*session->second);
  if (held != held_.end()) TellHeld(held->second.request);
}

void SessionTable::ForgetHeld(std::int64_t now_ns) {
  std::erase_if(held_, [&](const auto& entry) {
    const bool awaited = waiting_.contains(entry.first);
    if (now_ns - entry.second.since_ns <= (awaited ? kHeldAwaited_ns : kHeld_ns)) return false;
    changes_.push_back(AnswerTo(entry.second.request, palpate_SESSION_ENDED,
                                "it was held, and asks no more: the station has gone"));
    return true;
  });
}

CutExchange* SessionTable::CutsOf(const Session& session) {
  const auto scene = scenes_.find(session.tool().scene);
  return scene == scenes_.end() ? nullptr : &scene->second.cuts();
}

CutExchange::Changed SessionTable::TakerOf(SceneChanges& scene, std::int64_t now_ns) {
  return [&scene, now_ns](std::uint32_t solid, std::uint32_t block) {
    scene.TakeCut(solid, block, now_ns);
  };
}

std::unique_ptr<ServoLoop> SessionTable::LoopOf(const ServedTool& tool) const {
  const auto world = worlds_.find(tool.scene);
  if (world == worlds_.end()) return nullptr;
  std::size_t number = 0;
  for (const auto& other : tools_) {
    if (other.get() == &tool) break;
    if (other->scene == tool.scene) ++number;
  }
  return std::make_unique<ServoLoop>(world->second, number);
}

void SessionTable::Begin(Session& session) {
  if (CutExchange* const cuts = CutsOf(session)) cuts->Begin(session);
}

void SessionTable::RetireEnded(std::int64_t now_ns) {
  for (const auto& session : std::exchange(ending_, {})) {
    session->loop().Leave();
    const auto scene = scenes_.find(session->tool().scene);
    if (scene == scenes_.end() || session->loop().cuts().empty()) continue;
    scene->second.cuts().End(*session, TakerOf(scene->second, now_ns));
  }
}

void SessionTable::Request(const wire::WholeRequest& request) {
  const auto served =
      std::ranges::find_if(tools_, [&](const auto& tool) { return tool->scene == request.scene; });
  if (served == tools_.end() || !requests_heard_.IsNew(request.request)) return;
  wire::SceneWhole answer{};
  wire::FromText(request.scene, answer.scene);
  wire::FromText(request.by, answer.by);
  answer.request = request.request;
  answer.wish = request.wish;
  const auto scene = scenes_.find(request.scene);
  if (scene == scenes_.end()) {
    answer.server_run = server_run_;
    wire::FromText("nothing goes there: no tool of the scene cuts an object", answer.refusal);
    wholes_.push_back(answer);
  } else if (const std::string keeper = KeeperOf(request.scene); !keeper.empty()) {
    wire::FromText("station '" + keeper +
                       "' is in a trial there, which would count no more; wait until it ends, or "
                       "take its tool back",
                   answer.refusal);
    Answer(scene->second, answer);
  } else if (request.wish == palpate_WHOLE_AGAIN) {
    MakeWhole(scene->second, answer);
  } else {
    Bookmark(scene->second, answer);
  }
}

void SessionTable::Bookmark(SceneChanges& scene, wire::SceneWhole answer) {
  if (answer.wish == palpate_WHOLE_BOOKMARK) {
    scene.cuts().SetBookmark();
  } else if (!scene.cuts().cuts().has_bookmark()) {
    wire::FromText("the scene has no bookmark; set one first", answer.refusal);
  } else {
    for (Session* const session : SessionsOf(answer.scene)) {
      session->MakeWhole();
      session->HoldStart(true);
    }
    scene.GoBack(now_ns_);
  }
  Answer(scene, answer);
}

std::string SessionTable::KeeperOf(const std::string& scene) const {
  const auto keeper = std::ranges::find_if(sessions_, [&](const auto& entry) {
    return entry.second->tool().scene == scene && entry.second->keeps_scene();
  });
  return keeper == sessions_.end() ? "" : keeper->first;
}

std::vector<Session*> SessionTable::SessionsOf(const std::string& scene) {
  std::vector<Session*> all;
  for (const auto& [station, session] : sessions_) {
    if (session->tool().scene == scene) all.push_back(session.get());
  }
  for (const auto& session : ending_) {
    if (session->tool().scene == scene) all.push_back(session.get());
  }
  return all;
}

void SessionTable::MakeWhole(SceneChanges& scene, wire::SceneWhole answer) {
  for (Session* const session : SessionsOf(answer.scene)) {
    session->MakeWhole();
    session->HoldStart(false);
  }
  scene.MakeWhole();
  Answer(scene, answer);
}

void SessionTable::Answer(SceneChanges& scene, wire::SceneWhole& answer) {
  answer.server_run = server_run_;
  answer.last_change = scene.undone();
  answer.has_bookmark = scene.cuts().cuts().has_bookmark();
  wholes_.push_back(answer);
}

void SessionTable::EndAll(const std::string& reason) {
  for (auto& [station, session] : sessions_) {
    session->End(reason);
    Publish(*session);
    ending_.push_back(session);
  }
  RetireEnded(0);
  sessions_.clear();
  waiting_.clear();
  held_.clear();
}

std::vector<wire::SessionState> SessionTable::TakeChanges() {
  return std::exchange(changes_, {});
}

std::vector<SolidBlockNews> SessionTable::TakeCuts(std::int64_t now_ns) {
  std::vector<SolidBlockNews> news;
  for (auto& [name, scene] : scenes_) {
    for (SolidBlockNews& one : scene.TakeCuts(now_ns)) news.push_back(std::move(one));
  }
  return news;
}

std::vector<CutLogNews> SessionTable::TakeCutLogs(std::int64_t now_ns) {
  std::vector<CutLogNews> news;
  for (auto& [name, scene] : scenes_) {
    for (CutLogNews& one : scene.TakeCutLog(now_ns)) news.push_back(std::move(one));
  }
  return news;
}

void SessionTable::TellAgain(const wire::SolidBlock& block, std::int64_t now_ns) {
  scenes_.find(block.scene)->second.TellAgain(block, now_ns);
}

std::vector<wire::LoopWhole> SessionTable::TakeLoopWholes() {
  return std::exchange(loop_wholes_, {});
}

std::vector<wire::SceneWhole> SessionTable::TakeWholes() {
  return std::exchange(wholes_, {});
}

std::shared_ptr<const ServedTool> SessionTable::Find(const wire::SessionRequest& request,
                                                     std::string& refusal) const {
  std::string scenes;
  std::string tools;
  std::string last_scene;
  std::vector<std::shared_ptr<const ServedTool>> candidates;
  for (const auto& tool : tools_) {
    if (tool->scene != last_scene) AddName(scenes, tool->scene);
    last_scene = tool->scene;
    if (tool->scene != request.scene) continue;
    AddName(tools, tool->tool);
    if (request.tool[0] == '\0' || tool->tool == request.tool) candidates.push_back(tool);
  }
  if (candidates.size() == 1) return candidates.front();
  const std::string scene = std::string("scene '") + request.scene + "'";
  if (tools.empty()) {
    refusal = scene + " is not served here; choose one of: " + scenes;
  } else if (candidates.empty()) {
    refusal =
        std::string("tool '") + request.tool + "' is not in " + scene + "; choose one of: " + tools;
  } else {
    refusal = scene + " has several tools; choose one of: " + tools;
  }
  return nullptr;
}

void SessionTable::Admit(const wire::SessionRequest& request, std::int64_t now_ns) {
  std::string refusal;
  std::shared_ptr<const ServedTool> tool = Find(request, refusal);
  if (!tool) return Refuse(request, refusal, now_ns);
  const auto holder = std::ranges::find_if(
      sessions_, [&](const auto& entry) { return &entry.second->tool() == tool.get(); });
  if (holder != sessions_.end()) {
    return Refuse(request,
                  "tool '" + tool->tool + "' of scene '" + tool->scene +
                      "' is driven by station '" + holder->first +
                      "'; end that station, or drive another tool",
                  now_ns);
  }
  if (sessions_.size() >= kMaxStations) {
    return Refuse(request,
                  "this server holds " + std::to_string(kMaxStations) +
                      " stations, the maximum; end one of them",
                  now_ns);
  }
  const SessionClient client{ToSeal(request), std::string(request.device) == kMouse,
                             request.keeps_scene};
  std::unique_ptr<ServoLoop> loop = LoopOf(*tool);
  const auto session = std::make_shared<Session>(request.station, request.run, std::move(tool),
                                                 now_ns, client, std::move(loop));
  if (const auto scene = scenes_.find(session->tool().scene); scene != scenes_.end()) {
    // A session that works there already would find its work undone.
    const bool alone = std::ranges::none_of(
        sessions_, [&](const auto& entry) { return entry.second->tool().scene == scene->first; });
    const bool resumes = cut_off_[scene->first] == session->station();
    if (session->tool().whole_at_start && alone && !resumes && !scene->second.is_whole()) {
      wire::SceneWhole whole{};
      wire::FromText(scene->first, whole.scene);
      wire::FromText(session->station(), whole.by);
      MakeWhole(scene->second, whole);
    }
  }
  sessions_[request.station] = session;
  Publish(*session);
}

wire::SessionState SessionTable::AnswerTo(const wire::SessionRequest& request,
                                          wire::SessionPhase phase,
                                          const std::string& reason) const {
  wire::SessionState state{};
  wire::FromText(request.station, state.station);
  state.run = request.run;
  state.server_run = server_run_;
  state.phase = phase;
  wire::FromText(request.scene, state.scene);
  wire::FromText(request.tool, state.tool);
  wire::FromText(reason, state.reason);
  return state;
}

void SessionTable::Refuse(const wire::SessionRequest& request, const std::string& reason,
                          std::int64_t now_ns) {
  if (!refusals_.Take(now_ns)) {
    ++untold_;
    return;
  }
  changes_.push_back(AnswerTo(request, palpate_SESSION_REFUSED, reason));
}

void SessionTable::Publish(const Session& session) {
  wire::SessionState state{};
  wire::FromText(session.station(), state.station);
  state.run = session.run();
  state.server_run = server_run_;
  state.phase = session.phase();
  wire::FromText(session.tool().scene, state.scene);
  wire::FromText(session.tool().tool, state.tool);
  wire::FromText(session.reason(), state.reason);
  const auto standing = standings_.find(session.station());
  state.listeners = static_cast<std::uint32_t>(session.listeners());
  state.muted = standing != standings_.end() && standing->second.muted;
  state.start_depth_m = session.start_depth();
  wire::FromVec3(session.tool().model.reference(), state.tool_reference_m);
  state.stiffness_N_per_m = session.tool().model.parameters().stiffness;
  state.torsional_stiffness_Nm_per_rad = session.tool().model.parameters().torsional_stiffness;
  state.start_sequence = session.start_sequence();
  wire::FromPose(session.start(), state.start_position_m, state.start_orientation_wxyz);
  changes_.push_back(state);
}

}  // namespace palpate
