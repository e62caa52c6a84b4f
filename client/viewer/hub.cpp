#include "client/viewer/hub.h"

#include <algorithm>
#include <filesystem>
#include <random>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "common/dds/random_run.h"
#include "common/error.h"
#include "common/files/project_files.h"
#include "common/metrics/metrics_page.h"
#include "common/realtime/steady_clock.h"
#include "common/realtime/wall_clock.h"
#include "common/text/joined.h"

namespace palpate {
namespace {

/// The reason of a trial that its person stopped.
constexpr const char* kStopped = "stopped";

/// So many wishes to restore scenes are answered within a moment, at most.
constexpr std::size_t kOwnWishes = 256;
constexpr std::int64_t kStatistics_ns = 5'000'000'000;
constexpr std::int64_t kCall_ns = 100'000'000;  // between looks for free seats of an exam
/// A server's scenes are all heard if no other one was heard for so long.
constexpr std::int64_t kScenesHeard_ns = 1'000'000'000;

std::string RandomId() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}", random(), random());
}

/// palpate-station is installed beside this program.
std::string StationProgram() {
  return (std::filesystem::path(ProgramFolder()) / "palpate-station").string();
}

/// The recorder's arguments for the network of the mouse stations.
std::vector<std::string> RecorderWords(const ViewerOptions& options) {
  std::vector<std::string> words{"--domain=" + std::to_string(options.domain),
                                 "--transport=" + options.transport,
                                 "--network=" + options.network.interface};
  if (options.network.secured()) words.push_back("--identity=" + options.network.identity);
  for (const std::string& peer : options.network.peers) words.push_back("--peer=" + peer);
  return words;
}

std::string OrNone(const std::string& text) {
  return text.empty() ? "none" : text;
}

/// Makes a frame of the gateway's own.
FramePtr OwnFrame(TopicFeed::Channel channel, std::uint64_t instance, const std::string& json) {
  auto frame = std::make_shared<Frame>();
  frame->channel = channel;
  frame->instance = instance;
  frame->time_ns = WallClock_ns();
  frame->payload.assign(json.begin(), json.end());
  frame->state = true;
  return frame;
}

/// Returns whether a trial of the exercise begins with the scene restored.
bool Resets(const Exercise& exercise) {
  return AsksForCuts(exercise.criteria) && exercise.start != Exercise::Start::kAsItIs;
}

std::string KeptFor(const std::string& seat) {
  return "'" + seat + "' is kept for a candidate of the exam, who is about to begin there";
}

std::string TrialRunsIn(const std::string& scene) {
  return "a trial runs in scene '" + scene + "'; end it first";
}

template <class Map>
std::vector<std::string> KeysOf(const Map& map) {
  std::vector<std::string> keys;
  for (const auto& entry : map) keys.push_back(entry.first);
  return keys;
}

}  // namespace

Hub::Hub(boost::asio::io_context& io, const ViewerOptions& options)
    : options_(options),
      class_room_(options.course.empty() ? nullptr : std::make_unique<ClassRoom>(options.course)),
      listed_(options.tokens.empty() ? std::nullopt : std::optional(Tokens::Read(options.tokens))),
      exam_clock_(WallClock_ns(), SteadyNanoseconds()),
      gate_({options.host_names, options.origins},
            class_room_ ? class_room_->With(listed_.value_or(Tokens())) : listed_),
      places_(options.max_viewers),
      page_(options.page),
      feed_(options.domain, options.network),
      session_id_(RandomId()),
      // A random prefix: another gateway in the domain has mice of its own.
      mice_({options.max_mice, options.domain, options.transport, options.network, StationProgram(),
             "mouse_" + session_id_.substr(0, 4) + "_",
             // A gateway with an identity may write poses only under this prefix.
             options.network.secured() ? "mouse_" : "",
             [this](const std::string& station, const std::string& who) {
               return feed_.HasStation(station) ||
                      (gate_.tokens() &&
                       gate_.tokens()->NamesAnother(station, mice_.named_prefix(), who));
             },
             [this](MouseRoom::Holder holder) {
               const auto viewer = viewers_.find(holder);
               const bool has_name = viewer != viewers_.end() && viewer->second->holder();
               return has_name ? viewer->second->holder()->name : "";
             }},
            [this](const MouseRoom::News& news) { Tell(news); }),
      packer_(io),
      logged_ns_(SteadyNanoseconds()) {
  if (!class_room_) return;
  trials_ = std::make_unique<TrialRoom>(
      TrialRoom::Options{options.course, ProgramFolder(), RecorderWords(options)},
      class_room_->file(), [this](const TrialRoom::News& news) { Tell(news); });
  history_ = std::make_unique<HistoryDesk>(io, options.course, trials_->exercises());
  exams_ = std::make_unique<ExamRoom>(options_.course, class_room_->file(), class_room_->roster(),
                                      *trials_, exam_clock_.Now_s(SteadyNanoseconds()));
  scenes_heard_ns_ = SteadyNanoseconds();
  exam_seats_ = {
      [this](std::int64_t person, const std::string& scene) { return FreeSeats(person, scene); },
      [here = CountPages()](std::int64_t person) { return here(person) > 0; }};
  trials_->ScoreLeftovers();
}

void Hub::NoteAddress(const std::string& urls) {
  if (trials_) trials_->lock().Tell(urls);
}

bool Hub::MakeRoom(const std::string& address) {
  const std::int64_t now_ns = SteadyNanoseconds();
  const ViewerPlaces::Room room = places_.RoomFor(address, now_ns);
  if (room.leaves) {
    // At once: a viewer that reads nothing would delay an orderly close.
    const std::shared_ptr<Viewer> leaves = viewers_.at(*room.leaves);
    refusals_.Say(Refusal::kFull, leaves->visitor().name,
                  "its place is another address's, which has fewer (--max-viewers)", now_ns);
    leaves->Gone();
  }
  return room.is_there;
}

void Hub::Join(const std::shared_ptr<Viewer>& viewer) {
  viewers_[viewer->id()] = viewer;
  places_.Enter(viewer->id(), viewer->visitor().address, SteadyNanoseconds());
  if (class_room_ && viewer->holder()) class_room_->Enter(viewer->holder()->person, Scenes());
  class_changed_ = true;
}

void Hub::Leave(const Viewer& viewer) {
  traffic_.lost += viewer.frames_lost();
  if (viewer.frames_lost() > 0) {
    spdlog::info("viewer {} has left: {} frames sent, {} lost because it was slow",
                 viewer.visitor().name, viewer.frames_sent(), viewer.frames_lost());
  }
  const std::uint64_t id = viewer.id();
  places_.Leave(id);
  wishes_.Leave(id);
  viewers_.erase(id);  // a handler may be the last to hold it
  class_changed_ = true;
  Miss(id, "its page has gone", SteadyNanoseconds());
}

void Hub::Miss(std::uint64_t id, const std::string& reason, std::int64_t now_ns) {
  if (trials_ && trials_->is_running(id) && mice_.holds(id)) return mice_.Rest(id, now_ns);
  if (trials_) trials_->End(id, reason);
  mice_.Release(id, reason, now_ns);
}

void Hub::Return(const Viewer& viewer, std::int64_t now_ns) {
  if (!trials_ || !viewer.holder() || mice_.holds(viewer.id())) return;
  const std::uint64_t holder = trials_->HolderOf(viewer.holder()->person);
  if (holder == 0 || !mice_.Return(holder, viewer.id(), now_ns)) return;
  trials_->Return(holder, viewer.id(), now_ns);
}

void Hub::Tick(std::int64_t now_ns) {
  feed_.Poll(
      [&](const FramePtr& frame) {
        ++traffic_.taken;
        for (const auto& [id, viewer] : viewers_) viewer->Push(frame, now_ns);
      },
      [&](const wire::SessionState& state) { mice_.OnSession(state, now_ns); },
      [&](const wire::SceneWhole& whole) { HearOfWhole(whole); });
  if (std::exchange(scenes_heard_, feed_.scenes().size()) != feed_.scenes().size()) {
    scenes_heard_ns_ = now_ns;
  }
  mice_.Poll(now_ns);
  if (trials_) trials_->Poll(now_ns);
  if (exams_ && !feed_.server_lives()) exams_->EndTrials("the server has gone");
  if (exams_) {
    const std::int64_t set_by_s = exam_clock_.Follow(WallClock_ns(), now_ns);
    if (set_by_s != 0) exams_->ClockWasSet(set_by_s);
    if (now_ns - called_ns_ >= kCall_ns) {
      called_ns_ = now_ns;
      exams_->CallNext(exam_clock_.Now_s(now_ns), exam_seats_);
    }
    if (exams_->Poll(exam_clock_.Now_s(now_ns))) TellExam(now_ns);
  }
  refusals_.Poll(now_ns);
  TellClass(now_ns);
  // Flush may remove a viewer.
  std::vector<std::shared_ptr<Viewer>> viewers;
  viewers.reserve(viewers_.size());
  for (const auto& [id, viewer] : viewers_) viewers.push_back(viewer);
  for (const auto& viewer : viewers) {
    viewer->Flush(now_ns);
    viewer->Watch(now_ns);
  }
  if (now_ns - logged_ns_ >= kStatistics_ns) LogStatistics(now_ns);
}

void Hub::ReadTokensAnew(std::int64_t now_ns) {
  if (!options_.asks_for_tokens()) {
    return spdlog::info("there are no --tokens and no --course to read again");
  }
  try {
    if (class_room_) class_room_->roster().Read();
    const std::size_t ended =
        Renew(options_.tokens.empty() ? std::nullopt : std::optional(Tokens::Read(options_.tokens)),
              now_ns);
    spdlog::info("{} read again: {} tokens are valid; connections closed: {}",
                 options_.tokens + options_.course, gate_.tokens()->size(), ended);
  } catch (const Error& error) {
    spdlog::error("{}; the tokens read before remain valid", error.what());
  }
}

std::size_t Hub::Renew(std::optional<Tokens> tokens, std::int64_t now_ns) {
  gate_.Replace(class_room_ ? class_room_->With(tokens.value_or(Tokens())) : *tokens);
  listed_ = std::move(tokens);
  class_changed_ = true;
  std::size_t ended = 0;
  const auto viewers = viewers_;
  for (const auto& [id, viewer] : viewers) {
    if (viewer->holder() && gate_.tokens()->Has(*viewer->holder())) continue;
    if (class_room_ && viewer->holder()) {
      // After a mere change of name the viewer continues, with the tool in the hand.
      const Person* const person = class_room_->roster().Find(viewer->holder()->person);
      if (person != nullptr && person->hash == viewer->holder()->hash &&
          person->role == viewer->holder()->role) {
        viewer->Rename(person->name, person->station);
        continue;
      }
    }
    ++ended;
    mice_.Release(id, "its token was taken back", now_ns);
    viewer->Say(foxglove::Level::kError,
                "this connection ends: its token was taken back, or has another role now");
    viewer->Close(boost::beast::websocket::close_code::policy_error, "its token was taken back");
  }
  return ended;
}

std::optional<Roster::Made> Hub::MakeFirstTeacher() {
  if (!class_room_) return std::nullopt;
  auto teacher = class_room_->MakeFirstTeacher();
  if (teacher) Renew(listed_, SteadyNanoseconds());
  return teacher;
}

ClassRoom::Here Hub::CountPages() const {
  return [this](std::int64_t person) {
    return static_cast<int>(std::ranges::count_if(viewers_, [&](const auto& entry) {
      const auto& holder = entry.second->holder();
      return holder && holder->person == person;
    }));
  };
}

ClassRoom::Scenes Hub::Scenes() const {
  ClassRoom::Scenes scenes;
  for (const auto& [name, scene] : feed_.scenes()) scenes.insert(name);
  return scenes;
}

FramePtr Hub::Teach(const ClassCommand& command, Viewer& viewer) {
  const std::int64_t now_ns = SteadyNanoseconds();
  const std::string answer = class_room_->Do(
      command, listed_.value_or(Tokens()), Scenes(), CountPages(),
      [this](std::int64_t person) { return trials_->has_one_of(person) || exams_->Needs(person); });
  spdlog::info("{}: {}", viewer.Who(), ClassOpName(command.op));
  class_changed_ = true;
  if (ChangesTokens(command.op)) {
    // The score pages of a person whose link has ended are closed too.
    if (command.op != ClassCommand::Op::kRename) trials_->ForgetPages({command.person});
    Renew(listed_, now_ns);
  }
  if (command.op == ClassCommand::Op::kDelete) {
    exams_->Read();
    newest_trials_.erase(command.person);
  }
  // Instances for answers in flight: none replaces another, and their number is bounded.
  constexpr std::uint32_t kAnswersAtOnce = 16;
  return OwnFrame(TopicFeed::kClassAnswer, command.tag % kAnswersAtOnce, answer);
}

std::map<std::string, std::string> Hub::NamesAtTools() const {
  std::map<std::string, std::string> names;
  for (const auto& [id, viewer] : viewers_) {
    const std::string station = mice_.StationOf(id);
    if (!station.empty() && viewer->holder()) names[station] = viewer->holder()->name;
  }
  return names;
}

FramePtr Hub::OwnFrameOf(const Viewer& viewer) const {
  return OwnFrame(TopicFeed::kMe, 0, class_room_->OwnJson(viewer.holder()->person, NamesAtTools()));
}

FramePtr Hub::PeopleFrame() const {
  return OwnFrame(TopicFeed::kPeople, 0,
                  class_room_->PeopleJson(CountPages(), newest_trials_, trials_->exercises(),
                                          mice_.named_prefix()));
}

void Hub::TellClass(std::int64_t now_ns) {
  if (!class_room_ || !std::exchange(class_changed_, false)) return;
  const FramePtr people = PeopleFrame();
  for (const auto& [id, viewer] : viewers_) {
    if (!viewer->holder()) continue;
    viewer->Push(OwnFrameOf(*viewer), now_ns);
    viewer->Push(people, now_ns);  // no effect on viewers that may not subscribe to it
  }
}

void Hub::BeginToEnd(std::int64_t now_ns) {
  const auto viewers = viewers_;
  for (const auto& [id, viewer] : viewers) {
    if (trials_) trials_->End(id, "the gateway ends");
    viewer->Close(boost::beast::websocket::close_code::going_away, "the gateway ends");
  }
  mice_.ReleaseAll("the gateway ends", now_ns);
}

std::string Hub::Try(const TrialCommand& command, Viewer& viewer, std::int64_t now_ns) {
  try {
    switch (command.op) {
      case TrialCommand::Op::kBegin:
        BeginTrial(command, viewer, now_ns);
        break;
      case TrialCommand::Op::kStop:
        trials_->End(viewer.id(), kStopped);
        break;
      case TrialCommand::Op::kSubmit:
        trials_->Submit(viewer.id(), viewer.holder()->person, command.exercise, command.n);
        viewer.Push(ExercisesFrameOf(viewer), now_ns);
        break;
    }
  } catch (const Error& error) {
    // The page asked for a tool, and would wait for it.
    if (command.op == TrialCommand::Op::kBegin && !mice_.holds(viewer.id())) {
      TellState(viewer, {viewer.id(), "", "", "", "refused", error.what()});
    }
    return error.what();
  }
  return "";
}

std::string Hub::SeatForPractice(const Exercise& exercise, const Viewer& viewer) const {
  // The person's seat, if it belongs to that scene.
  const std::string seat = class_room_->SeatOf(viewer.holder()->person);
  const bool has_seat = seat.starts_with(exercise.scene_name + "-");
  const std::string scene = has_seat ? seat : exercise.scene_name;
  if (!seat.empty() && !has_seat) {
    throw Error("your seat is '" + seat + "', which belongs to another scene");
  }
  if (const std::string absent = WhyAbsent(scene); !absent.empty()) throw Error(absent);
  if (exams_->IsKept(scene)) throw Error(KeptFor(scene));
  const bool is_reset = Resets(exercise);
  // A trial's tool is given back before its recorder has ended.
  if (mice_.IsTaken(scene, is_reset ? "" : exercise.tool, viewer.id()) ||
      (is_reset && trials_->is_in(scene))) {
    throw Error("somebody is working in scene '" + scene +
                "'; wait, or ask your teacher for a seat of your own");
  }
  return scene;
}

bool Hub::KnowsScenes() const {
  return SteadyNanoseconds() - scenes_heard_ns_ > kScenesHeard_ns;
}

std::vector<std::string> Hub::FreeSeats(std::int64_t person, const std::string& scene) const {
  if (!WhyAbsent(scene).empty() || !KnowsScenes()) return {};
  std::vector<std::string> seats = SeatsOf(scene, Scenes());
  if (seats.empty()) seats.push_back(scene);
  std::erase_if(seats, [&](const std::string& seat) {
    const std::int64_t owner = class_room_->OwnerOf(seat);
    return mice_.IsTaken(seat, "", 0) || trials_->is_in(seat) || feed_.HasStationIn(seat) ||
           (owner != 0 && !exams_->Sits(owner));
  });
  for (const std::string& preferred :
       {class_room_->SeatOf(person), exams_->LastSeatOf(person, scene)}) {
    const auto found = std::ranges::find(seats, preferred);
    if (found != seats.end()) std::rotate(seats.begin(), found, found + 1);
  }
  return seats;
}

void Hub::BeginTrial(const TrialCommand& command, Viewer& viewer, std::int64_t now_ns) {
  const std::string& name = command.exercise;
  if (const std::string why = RefuseWish(Wish::kTake, viewer, now_ns); !why.empty()) {
    throw Error(why);
  }
  const Exercise* const exercise = trials_->Find(name);
  if (exercise == nullptr) throw Error("there is no exercise '" + name + "'");
  // Checked before anything changes: a second page must not restore the scene during a trial.
  const std::int64_t person = viewer.holder()->person;
  // All candidates of an exam have the same.
  const bool chooses = !command.tool.empty() && !exams_->Sits(person);
  const std::string& tool = chooses ? command.tool : exercise->tool;
  if (std::ranges::find(exercise->tools, tool) == exercise->tools.end()) {
    throw Error("tool '" + tool + "' is not in scene '" + exercise->scene_name +
                "'; choose one of: " + Joined(exercise->tools));
  }
  trials_->CheckMayBegin(person);
  std::string seat;
  if (exams_->Sits(person)) {
    const std::string absent = KnowsScenes() ? WhyAbsent(exercise->scene_name) : "";
    if (!absent.empty()) throw Error(absent);
    const std::int64_t now_s = exam_clock_.Now_s(now_ns);
    exams_->TaskToBegin(person, name, now_s);
    seat = exams_->SeatToBegin(person, now_s, exam_seats_);
    if (seat.empty()) return;  // the exam's state tells for what the person waits
  } else {
    seat = SeatForPractice(*exercise, viewer);
  }
  const MouseCommand take{MouseCommand::Op::kTake, seat, tool, {}};
  mice_.Release(viewer.id(), "a trial begins", now_ns);
  if (Resets(*exercise)) {
    AskForWhole(
        take.scene,
        exercise->start == Exercise::Start::kWhole ? palpate_WHOLE_AGAIN : palpate_WHOLE_BACK,
        viewer.Who());
  }
  // The recorder first: it must record the first pose.
  const std::string station =
      mice_.Take(viewer.id(), viewer.holder()->station, take, "", now_ns, true);
  if (station.empty()) return;  // its page has been told
  try {
    if (exams_->Sits(person)) {
      exams_->Begin(
          {viewer.id(), person, name, station, take.scene, feed_.scenes().at(take.scene).hash},
          exam_clock_.Now_s(now_ns), now_ns);
    } else {
      trials_->Begin(viewer.id(), person, name, station, take.scene, now_ns);
    }
  } catch (const Error& error) {
    mice_.Release(viewer.id(), error.what(), now_ns);
    throw;
  }
}

void Hub::AskHistory(const HistoryWish& wish, bool for_teacher,
                     std::function<void(HistoryDesk::Answer)> use) {
  if (!history_) return use({404, "text/plain; charset=utf-8", "there is no course here\n"});
  const bool is_page = wish.as == HistoryWish::As::kJson && wish.person != 0;
  history_->Ask(wish, for_teacher, is_page ? trials_->PagesOf(wish.person) : HistoryDesk::Pages(),
                std::move(use));
}

FramePtr Hub::ExercisesFrameOf(const Viewer& viewer) const {
  return OwnFrame(TopicFeed::kExercises, 0,
                  IsInExam(viewer) ? R"({"exercises": []})"
                                   : trials_->ListJson(viewer.holder()->person, viewer.teaches()));
}

bool Hub::IsInExam(const Viewer& viewer) const {
  return viewer.holder() && SitsExam(viewer.holder()->person);
}

FramePtr Hub::ExamFrameOf(const Viewer& viewer) const {
  const std::int64_t person = viewer.holder() ? viewer.holder()->person : 0;
  return OwnFrame(
      TopicFeed::kExam, 0,
      exams_->StateJson(person, viewer.teaches(), exam_clock_.Now_s(SteadyNanoseconds())));
}

FramePtr Hub::Examine(std::string_view wish, std::int64_t now_ns) {
  const FramePtr answer =
      OwnFrame(TopicFeed::kExamAnswer, 0, exams_->Do(wish, exam_clock_.Now_s(now_ns)));
  for (const auto& [id, viewer] : viewers_) {
    if (IsInExam(*viewer) && !trials_->is_at_one(id)) {
      mice_.Release(id, "an exam begins", now_ns);
    }
    // An open exam hides the exercises, and closing it shows them again.
    if (viewer->holder()) viewer->Push(ExercisesFrameOf(*viewer), now_ns);
  }
  return answer;
}

void Hub::TellExam(std::int64_t now_ns) {
  for (const auto& [id, viewer] : viewers_) {
    if (viewer->holder()) viewer->Push(ExamFrameOf(*viewer), now_ns);
  }
}

void Hub::Tell(const TrialRoom::News& news) {
  /// The person holds the tool, or has released it with the trial's end.
  static const std::set<std::string> kHolds = {"preparing", "running", "scored", "unscored",
                                               "kept"};
  const std::int64_t now_ns = SteadyNanoseconds();
  newest_trials_[news.person] = news;
  class_changed_ = true;
  if (news.phase == "running") mice_.Go(news.holder, now_ns);
  if (exams_ && (news.phase == "kept" || news.phase == "scored" || news.phase == "unscored")) {
    exams_->Heard(news);
  }
  // Trials of an exam are scored when their person has released the tool.
  if (news.holder != 0 && !kHolds.contains(news.phase)) {
    // The person's own request needs no message.
    mice_.Release(news.holder, news.reason == kStopped ? "" : "the trial ends: " + news.reason,
                  now_ns);
  }
  nlohmann::json json = {{"exercise", news.exercise}, {"n", news.n},
                         {"phase", news.phase},       {"reason", news.reason},
                         {"whole", news.whole},       {"points", nullptr},
                         {"passed", news.passed},     {"submitted", news.submitted},
                         {"page", news.page},         {"left_s", news.left_s},
                         {"ahead", news.ahead}};
  if (SitsExam(news.person)) json["page"] = "";
  if (news.points) json["points"] = *news.points;
  const bool is_over = news.phase == "scored" || news.phase == "unscored" || news.phase == "kept";
  spdlog::info("{}: {}{}{}", trials_->NameOf(news), news.phase, news.reason.empty() ? "" : ", ",
               news.reason);
  // All pages of the person: the one that began the trial may be closed.
  for (const auto& [id, viewer] : viewers_) {
    if (!viewer->holder() || viewer->holder()->person != news.person) continue;
    if (news.holder != 0) viewer->Push(OwnFrame(TopicFeed::kTrial, 0, ToText(json)), now_ns);
    if (is_over) viewer->Push(ExercisesFrameOf(*viewer), now_ns);
  }
}

void Hub::Tell(const MouseRoom::News& news) {
  if (trials_ && (news.phase == "ended" || news.phase == "refused")) {
    const std::string what = news.lost               ? "cut short"
                             : news.phase == "ended" ? "the tool is given back"
                                                     : "the tool is refused";
    trials_->End(news.holder, what + (news.reason.empty() ? "" : ": " + news.reason), !news.lost);
  }
  const auto viewer = viewers_.find(news.holder);
  if (viewer == viewers_.end()) return;
  const std::shared_ptr<Viewer> keep = viewer->second;
  places_.Holds(news.holder, mice_.holds(news.holder));
  class_changed_ = true;  // who holds a tool is named
  if (news.phase == "refused") {
    keep->Say(foxglove::Level::kError, "the tool is refused: " + news.reason);
  }
  TellState(*keep, news);
}

void Hub::TellState(Viewer& viewer, const MouseRoom::News& news) {
  viewer.TellMouseState(OwnFrame(TopicFeed::kMouseState, 0,
                                 ToText(nlohmann::json({{"station", news.station},
                                                        {"scene", news.scene},
                                                        {"tool", news.tool},
                                                        {"phase", news.phase},
                                                        {"reason", news.reason}}))));
}

std::string Hub::RefuseWish(Wish wish, Viewer& viewer, std::int64_t now_ns) {
  const WishLimits::Verdict verdict =
      wishes_.Ask(wish, viewer.id(), viewer.visitor().address, now_ns);
  if (verdict.granted) return "";
  const std::string reason = TooOften(wish);
  refusals_.Say(wish == Wish::kTake ? Refusal::kTakes : Refusal::kWishes, viewer.Who(), reason,
                now_ns);
  if (verdict.tell) viewer.Say(foxglove::Level::kError, reason);
  return reason;
}

bool Hub::AskForWhole(const std::string& scene, wire::WholeWish wish, const std::string& by) {
  if (!feed_.scenes().contains(scene)) return false;
  wire::WholeRequest request{};
  wire::FromText(scene, request.scene);
  request.request = RandomRun();
  wire::FromText(by, request.by);
  request.wish = wish;
  own_wishes_.push_back(request.request);
  if (own_wishes_.size() > kOwnWishes) own_wishes_.pop_front();
  return feed_.Ask(request);
}

void Hub::HearOfWhole(const wire::SceneWhole& whole) {
  // Without a request: a station's session began in a scene that is then made whole.
  if (!trials_ || whole.request == 0 || whole.wish == palpate_WHOLE_BOOKMARK) return;
  const bool is_own = std::ranges::find(own_wishes_, whole.request) != own_wishes_.end();
  const bool is_refused = whole.refusal[0] != '\0';
  // A trial that begins in the state that another one left would be worth nothing.
  if (is_own && is_refused) {
    trials_->EndIn(whole.scene, std::string("the scene is not restored: ") + whole.refusal);
  }
  // The server refuses it once the trial's station has its tool, so it was just before.
  if (!is_own && !is_refused) {
    trials_->EndIn(whole.scene, std::string(whole.by) + " restored the scene, past this gateway");
  }
}

FramePtr Hub::AskReplay(ReplayWish wish, Viewer& viewer, std::int64_t now_ns) {
  std::string refusal = RefuseWish(Wish::kReplay, viewer, now_ns);
  if (refusal.empty()) {
    wish.request.request = RandomRun();
    wire::FromText(viewer.Who(), wish.request.by);
    refusal = feed_.Ask(wish.request);
  }
  // One instance per kind of wish: an answer replaces only an answer to the same kind.
  return OwnFrame(TopicFeed::kReplayAnswer, wish.request.kind,
                  ReplayAnswer(wish.tag, wish.request.request, refusal));
}

std::string Hub::Operate(const OperateCommand& command, const std::string& by) {
  if (command.goal) {
    const auto& [scene, text, limit] = *command.goal;
    // The number of scenes is bounded, so goals cannot fill the memory.
    if (!feed_.scenes().contains(scene)) return "scene '" + scene + "' is not served here";
    std::vector<std::string> all = SeatsOf(scene, Scenes());
    all.push_back(scene);
    for (const std::string& one : all) {
      const nlohmann::json json = {{"scene", one}, {"text", text}, {"limit_N", limit}};
      const FramePtr frame =
          OwnFrame(TopicFeed::kGoal, std::hash<std::string>{}(one), ToText(json));
      goals_[one] = frame;
      const std::int64_t now_ns = SteadyNanoseconds();
      for (const auto& [id, viewer] : viewers_) viewer->Push(frame, now_ns);
    }
    spdlog::info("{}: the goal of '{}' is set", by, scene);
    return "";
  }
  if (feed_.server_run() == 0) return "no server has been found";
  wire::OperateRequest request{};
  wire::FromText(command.station, request.station);
  request.server_run = feed_.server_run();
  request.request = RandomRun();
  request.wish = command.wish;
  wire::FromText(by, request.by);
  if (!feed_.Ask(request)) return "the network is busy; try again";
  spdlog::info("{}: {} station '{}'", by, OperateWishName(command.wish), command.station);
  return "";
}

std::string Hub::WhyAbsent(const std::string& scene) const {
  if (!feed_.server_lives()) {
    return feed_.server_run() == 0 ? "there is no server yet"
                                   : "there is no server: the last one has ended";
  }
  return feed_.scenes().contains(scene) ? "" : "no server serves scene '" + scene + "'";
}

std::string Hub::WhyNotAt(const Viewer& viewer, const std::string& scene) const {
  if (IsInExam(viewer)) return kInExam;
  if (exams_ && exams_->IsKept(scene)) return KeptFor(scene);
  if (!class_room_ || viewer.teaches()) return "";
  return class_room_->WhyNotAt(viewer.holder() ? viewer.holder()->person : 0, scene);
}

std::string Hub::WhyNotRestore(const Viewer& viewer, const std::string& scene) const {
  if (!trials_ || !trials_->is_in(scene)) return WhyNotAt(viewer, scene);
  // Not even its person or a teacher: what was cut would count no more.
  return TrialRunsIn(scene);
}

void Hub::Take(Viewer& viewer, const MouseCommand& command, std::int64_t now_ns) {
  std::string refusal = RefuseWish(Wish::kTake, viewer, now_ns);
  const std::optional<Tokens::Holder>& holder = viewer.holder();
  if (refusal.empty()) refusal = WhyNotAt(viewer, command.scene);
  // The scene may have further burs, which would cut what another's trial is graded by.
  if (refusal.empty() && trials_ && trials_->is_cut_in(command.scene)) {
    refusal = TrialRunsIn(command.scene);
  }
  if (refusal.empty()) {
    mice_.Take(viewer.id(), holder ? holder->station : "", command, WhyAbsent(command.scene),
               now_ns);
    return;
  }
  // The page expects an answer to each; the newest one suffices.
  TellState(viewer, {viewer.id(), "", command.scene, command.tool, "refused", refusal});
}

Hub::Traffic Hub::AllTraffic() const {
  Traffic all = traffic_;
  for (const auto& [id, viewer] : viewers_) all.lost += viewer->frames_lost();
  return all;
}

std::string Hub::Health() const {
  nlohmann::json compiling;
  if (const wire::SceneProgress* of = feed_.compiling()) {
    compiling = {{"scene", of->scene}, {"stage", of->stage}, {"done", of->done}};
  }
  return ToText(nlohmann::json({{"viewers", viewers_.size()},
                                {"max_viewers", options_.max_viewers},
                                {"frames_sent", traffic_.sent},
                                {"frames_dropped", AllTraffic().lost},
                                {"bytes_sent", traffic_.bytes},
                                {"mice", mice_.size()},
                                {"refusals", refusals_.count()},
                                {"stations", feed_.stations()},
                                {"scenes", KeysOf(feed_.scenes())},
                                {"server_run", fmt::format("{:x}", feed_.server_run())},
                                {"server_lives", feed_.server_lives()},
                                {"compiling", compiling},
                                {"version", PALPATE_VERSION}}));
}

std::string Hub::Metrics() const {
  MetricsPage page;
  page.Add(metric::kGatewayBuild, 1.0, {{"version", PALPATE_VERSION}});
  page.Add(metric::kGatewayMemory, ResidentMemoryBytes());
  page.Add(metric::kGatewayViewers, std::uint64_t{viewers_.size()});
  page.Add(metric::kGatewayViewersLimit, std::uint64_t{options_.max_viewers});
  page.Add(metric::kGatewayMice, std::uint64_t{mice_.size()});
  page.Add(metric::kGatewayStations, std::uint64_t{feed_.stations().size()});
  page.Add(metric::kGatewayScenes, std::uint64_t{feed_.scenes().size()});
  page.Add(metric::kGatewayIn, traffic_.taken);
  page.Add(metric::kGatewayOut, traffic_.sent);
  page.Add(metric::kGatewayDropped, AllTraffic().lost);
  page.Add(metric::kGatewayBytes, traffic_.bytes);
  page.Add(metric::kGatewayRefusals, refusals_.count());
  return page.ToText();
}

void Hub::LogStatistics(std::int64_t now_ns) {
  const double seconds = 1e-9 * static_cast<double>(now_ns - logged_ns_);
  const Traffic now = AllTraffic();
  const auto rate = [&](std::uint64_t Traffic::*of) {
    return static_cast<double>(now.*of - logged_.*of) / seconds;
  };
  spdlog::info(
      "viewers {}  frames in {:.0f}/s  out {:.0f}/s  {:.2f} MB/s  lost {} (+{})  stations {}  "
      "scenes {}",
      viewers_.size(), rate(&Traffic::taken), rate(&Traffic::sent), 1e-6 * rate(&Traffic::bytes),
      now.lost, now.lost - logged_.lost, OrNone(Joined(feed_.stations())),
      OrNone(Joined(KeysOf(feed_.scenes()))));
  logged_ = now;
  logged_ns_ = now_ns;
}

}  // namespace palpate
