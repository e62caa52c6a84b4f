#include "client/viewer/course_desk.h"

#include <algorithm>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "common/error.h"
#include "common/files/project_files.h"
#include "common/realtime/steady_clock.h"
#include "common/realtime/wall_clock.h"
#include "common/text/joined.h"

namespace palpate {
namespace {

/// The reason of a trial that its person stopped.
constexpr const char* kStopped = "stopped";
constexpr std::int64_t kCall_ns = 100'000'000;  // between looks for free seats of an exam
/// A server's scenes are all heard if no other one was heard for so long.
constexpr std::int64_t kScenesHeard_ns = 1'000'000'000;

/// The recorder's arguments for the network of the mouse stations.
std::vector<std::string> RecorderWords(const ViewerOptions& options) {
  std::vector<std::string> words{"--domain=" + std::to_string(options.domain),
                                 "--transport=" + options.transport,
                                 "--network=" + options.network.interface};
  if (options.network.secured()) words.push_back("--identity=" + options.network.identity);
  for (const std::string& peer : options.network.peers) words.push_back("--peer=" + peer);
  return words;
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

}  // namespace

CourseDesk::CourseDesk(boost::asio::io_context& io, const ViewerOptions& options, Viewers& viewers,
                       TopicFeed& feed, MouseRoom& mice, Rights& rights)
    : viewers_(viewers),
      feed_(feed),
      mice_(mice),
      rights_(rights),
      class_room_(*rights.class_room()),
      prefix_(options.mouse_prefix()),
      trials_({options.course, ProgramFolder(), RecorderWords(options)}, class_room_.file(),
              [this](const TrialRoom::News& news) { Tell(news); }),
      history_(io, options.course, trials_.pages().exercises()),
      exam_clock_(WallClock_ns(), SteadyNanoseconds()),
      exams_(options.course, class_room_.file(), class_room_.roster(), trials_,
             exam_clock_.Now_s(SteadyNanoseconds())),
      exam_seats_{[this](std::int64_t person, const std::string& scene) {
                    return FreeSeats(person, scene);
                  },
                  [here = CountPages()](std::int64_t person) { return here(person) > 0; }},
      scenes_heard_ns_(SteadyNanoseconds()) {
  trials_.ScoreLeftovers();
}

void CourseDesk::Enter(const Viewer& viewer) {
  if (viewer.guest().holder) class_room_.Enter(viewer.guest().person(), NamesOf(feed_.scenes()));
  NoteChange();
}

void CourseDesk::Tick(std::int64_t now_ns) {
  if (std::exchange(scenes_heard_, feed_.scenes().size()) != feed_.scenes().size()) {
    scenes_heard_ns_ = now_ns;
  }
  trials_.Poll(now_ns);
  if (!feed_.server().lives) exams_.EndTrials("the server has gone");
  const std::int64_t set_by_s = exam_clock_.Follow(WallClock_ns(), now_ns);
  if (set_by_s != 0) exams_.ClockWasSet(set_by_s);
  if (now_ns - called_ns_ >= kCall_ns) {
    called_ns_ = now_ns;
    exams_.CallNext(exam_clock_.Now_s(now_ns), exam_seats_);
  }
  if (exams_.Poll(exam_clock_.Now_s(now_ns))) {
    ForEachPage([&](Viewer& viewer) { viewer.Push(ExamFrameOf(viewer), now_ns); });
  }
  if (!std::exchange(changed_, false)) return;
  const FramePtr people = PeopleFrame();
  ForEachPage([&](Viewer& viewer) {
    viewer.Push(OwnFrameOf(viewer), now_ns);
    viewer.Push(people, now_ns);  // no effect on viewers that may not subscribe to it
  });
}

void CourseDesk::ForEachPage(const std::function<void(Viewer&)>& action) const {
  for (const auto& [id, viewer] : viewers_.all()) {
    if (viewer->guest().holder) action(*viewer);
  }
}

FramePtr CourseDesk::Kept(std::uint32_t channel, const Viewer& viewer) {
  switch (channel) {
    case TopicFeed::kMe:
      return OwnFrameOf(viewer);
    case TopicFeed::kPeople:
      return PeopleFrame();
    case TopicFeed::kExercises:
      return ExercisesFrameOf(viewer);
    case TopicFeed::kExam:
      return ExamFrameOf(viewer);
    default:
      return nullptr;
  }
}

ClassRoom::Here CourseDesk::CountPages() const {
  return [this](std::int64_t person) {
    return static_cast<int>(std::ranges::count_if(viewers_.all(), [&](const auto& entry) {
      const auto& holder = entry.second->guest().holder;
      return holder && holder->person == person;
    }));
  };
}

FramePtr CourseDesk::Teach(const ClassCommand& command, Viewer& viewer) {
  const std::string answer =
      class_room_.Do(command, rights_.listed(), NamesOf(feed_.scenes()), CountPages(),
                     [this](std::int64_t person) {
                       return trials_.now().has_one_of(person) || exams_.Needs(person);
                     });
  spdlog::info("{}: {}", viewer.guest().Who(), ClassOpName(command.op));
  changed_ = true;
  if (ChangesTokens(command.op)) {
    // The score pages of a person whose link has ended are closed too.
    if (command.op != ClassCommand::Op::kRename) trials_.pages().Forget({command.person});
    rights_.Renew();
  }
  if (command.op == ClassCommand::Op::kDelete) {
    exams_.ReadOf(command.person);
    newest_trials_.erase(command.person);
  }
  // Instances for answers in flight: none replaces another, and their number is bounded.
  constexpr std::uint32_t kAnswersAtOnce = 16;
  return OwnFrame(TopicFeed::kClassAnswer, command.tag % kAnswersAtOnce, answer);
}

std::map<std::string, std::string> CourseDesk::NamesAtTools() const {
  std::map<std::string, std::string> names;
  for (const auto& [id, viewer] : viewers_.all()) {
    const std::string station = mice_.StationOf(id);
    if (!station.empty() && viewer->guest().holder) names[station] = viewer->guest().holder->name;
  }
  return names;
}

FramePtr CourseDesk::OwnFrameOf(const Viewer& viewer) const {
  return OwnFrame(TopicFeed::kMe, 0, class_room_.OwnJson(viewer.guest().person(), NamesAtTools()));
}

FramePtr CourseDesk::PeopleFrame() {
  return OwnFrame(
      TopicFeed::kPeople, 0,
      class_room_.PeopleJson(CountPages(), newest_trials_, trials_.pages().exercises(), prefix_));
}

std::string CourseDesk::Try(const TrialCommand& command, Viewer& viewer, std::int64_t now_ns) {
  try {
    switch (command.op) {
      case TrialCommand::Op::kBegin:
        BeginTrial(command, viewer, now_ns);
        break;
      case TrialCommand::Op::kStop:
        trials_.End(viewer.id(), kStopped);
        break;
      case TrialCommand::Op::kSubmit:
        trials_.Submit(viewer.id(), viewer.guest().person(), command.exercise, command.n);
        viewer.Push(ExercisesFrameOf(viewer), now_ns);
        break;
    }
  } catch (const Error& error) {
    // The page asked for a tool, and would wait for it.
    if (command.op == TrialCommand::Op::kBegin && !mice_.holds(viewer.id())) {
      viewer.TellMouseState(MouseStateFrame({viewer.id(), "", "", "", "refused", error.what()}));
    }
    return error.what();
  }
  return "";
}

std::string CourseDesk::SeatForPractice(const Exercise& exercise, const Viewer& viewer) const {
  // The person's seat, if it belongs to that scene.
  const std::string seat = class_room_.SeatOf(viewer.guest().person());
  const bool has_seat = seat.starts_with(exercise.scene_name + "-");
  const std::string scene = has_seat ? seat : exercise.scene_name;
  if (!seat.empty() && !has_seat) {
    throw Error("your seat is '" + seat + "', which belongs to another scene");
  }
  if (const std::string absent = feed_.WhyAbsent(scene); !absent.empty()) throw Error(absent);
  if (exams_.IsKept(scene)) throw Error(KeptFor(scene));
  const bool is_reset = Resets(exercise);
  // A trial's tool is given back before its recorder has ended.
  if (mice_.IsTaken(scene, is_reset ? "" : exercise.tool, viewer.id()) ||
      (is_reset && trials_.now().is_in(scene))) {
    throw Error("somebody is working in scene '" + scene +
                "'; wait, or ask your teacher for a seat of your own");
  }
  return scene;
}

bool CourseDesk::KnowsScenes() const {
  return SteadyNanoseconds() - scenes_heard_ns_ > kScenesHeard_ns;
}

std::vector<std::string> CourseDesk::FreeSeats(std::int64_t person,
                                               const std::string& scene) const {
  if (!feed_.WhyAbsent(scene).empty() || !KnowsScenes()) return {};
  std::vector<std::string> seats = SeatsOf(scene, NamesOf(feed_.scenes()));
  if (seats.empty()) seats.push_back(scene);
  std::erase_if(seats, [&](const std::string& seat) {
    const std::int64_t owner = class_room_.OwnerOf(seat);
    return mice_.IsTaken(seat, "", 0) || trials_.now().is_in(seat) || feed_.HasStationIn(seat) ||
           (owner != 0 && !exams_.Sits(owner));
  });
  const auto own = std::ranges::find(seats, class_room_.SeatOf(person));
  if (own != seats.end()) std::rotate(seats.begin(), own, own + 1);
  return seats;
}

void CourseDesk::BeginTrial(const TrialCommand& command, Viewer& viewer, std::int64_t now_ns) {
  const std::string& name = command.exercise;
  if (const std::string why = viewers_.Refuse(Wish::kTake, viewer, now_ns); !why.empty()) {
    throw Error(why);
  }
  const Exercise* const exercise = trials_.pages().Find(name);
  if (exercise == nullptr) throw Error("there is no exercise '" + name + "'");
  // Checked before anything changes: a second page must not restore the scene during a trial.
  const std::int64_t person = viewer.guest().person();
  // All candidates of an exam have the same.
  const bool chooses = !command.tool.empty() && !exams_.Sits(person);
  const std::string& tool = chooses ? command.tool : exercise->tool;
  if (std::ranges::find(exercise->tools, tool) == exercise->tools.end()) {
    throw Error("tool '" + tool + "' is not in scene '" + exercise->scene_name +
                "'; choose one of: " + Joined(exercise->tools));
  }
  trials_.now().CheckMayBegin(person);
  std::string seat;
  if (exams_.Sits(person)) {
    const std::string absent = KnowsScenes() ? feed_.WhyAbsent(exercise->scene_name) : "";
    if (!absent.empty()) throw Error(absent);
    seat = exams_.SeatToBegin(person, name, exam_clock_.Now_s(now_ns), exam_seats_);
    if (seat.empty()) return;  // the exam's state tells for what the person waits
  } else {
    seat = SeatForPractice(*exercise, viewer);
  }
  const MouseCommand take{MouseCommand::Op::kTake, seat, tool, {}};
  mice_.Release(viewer.id(), "a trial begins", now_ns);
  if (Resets(*exercise)) {
    feed_.AskForWhole(
        take.scene,
        exercise->start == Exercise::Start::kWhole ? palpate_WHOLE_AGAIN : palpate_WHOLE_BACK,
        viewer.guest().Who());
  }
  // The recorder first: it must record the first pose.
  const std::string station =
      mice_.Take(viewer.id(), viewer.guest().holder->station, take, "", now_ns, true);
  if (station.empty()) return;  // its page has been told
  try {
    if (exams_.Sits(person)) {
      exams_.Begin(
          {viewer.id(), person, name, station, take.scene, feed_.scenes().at(take.scene).hash},
          exam_clock_.Now_s(now_ns), now_ns);
    } else {
      trials_.Begin(viewer.id(), person, name, station, take.scene, now_ns);
    }
  } catch (const Error& error) {
    mice_.Release(viewer.id(), error.what(), now_ns);
    throw;
  }
}

void CourseDesk::AskHistory(const HistoryWish& wish, bool for_teacher,
                            std::function<void(HistoryDesk::Answer)> use) {
  const bool is_page = wish.as == HistoryWish::As::kJson && wish.person != 0;
  history_.Ask(wish, for_teacher,
               is_page ? trials_.pages().PagesOf(wish.person) : HistoryDesk::Pages(),
               std::move(use));
}

FramePtr CourseDesk::ExercisesFrameOf(const Viewer& viewer) {
  return OwnFrame(TopicFeed::kExercises, 0,
                  IsInExam(viewer)
                      ? R"({"exercises": []})"
                      : trials_.pages().ListJson(viewer.guest().person(), viewer.guest().teaches));
}

FramePtr CourseDesk::ExamFrameOf(const Viewer& viewer) const {
  return OwnFrame(TopicFeed::kExam, 0,
                  exams_.StateJson(viewer.guest().person(), viewer.guest().teaches,
                                   exam_clock_.Now_s(SteadyNanoseconds())));
}

FramePtr CourseDesk::Examine(std::string_view wish, std::int64_t now_ns) {
  const FramePtr answer =
      OwnFrame(TopicFeed::kExamAnswer, 0, exams_.Do(wish, exam_clock_.Now_s(now_ns)));
  for (const auto& [id, viewer] : viewers_.all()) {
    if (IsInExam(*viewer) && !trials_.now().is_at_one(id)) {
      mice_.Release(id, "an exam begins", now_ns);
    }
    // An open exam hides the exercises, and closing it shows them again.
    if (viewer->guest().holder) viewer->Push(ExercisesFrameOf(*viewer), now_ns);
  }
  return answer;
}

void CourseDesk::Tell(const TrialRoom::News& news) {
  /// The person holds the tool, or has released it with the trial's end.
  static const std::set<std::string> kHolds = {"preparing", "running", "scored", "unscored",
                                               "kept"};
  const std::int64_t now_ns = SteadyNanoseconds();
  newest_trials_[news.person] = news;
  changed_ = true;
  if (news.phase == "running") mice_.Go(news.holder, now_ns);
  const bool is_over = news.phase == "scored" || news.phase == "unscored" || news.phase == "kept";
  if (is_over) exams_.ReadOf(news.person);
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
  if (exams_.Sits(news.person)) json["page"] = "";
  if (news.points) json["points"] = *news.points;
  // All pages of the person: the one that began the trial may be closed.
  ForEachPage([&](Viewer& viewer) {
    if (viewer.guest().person() != news.person) return;
    if (news.holder != 0) viewer.Push(OwnFrame(TopicFeed::kTrial, 0, ToText(json)), now_ns);
    if (is_over) viewer.Push(ExercisesFrameOf(viewer), now_ns);
  });
}

std::string CourseDesk::WhyNotInExam(std::int64_t person) const {
  return exams_.Sits(person) ? "an exam is open: begin its next task" : "";
}

std::string CourseDesk::WhyNotAt(const Viewer& viewer, const std::string& scene) const {
  const Guest& guest = viewer.guest();
  if (IsInExam(viewer)) return WhyNotInExam(guest.person());
  if (exams_.IsKept(scene)) return KeptFor(scene);
  return guest.teaches ? "" : class_room_.WhyNotAt(guest.person(), scene);
}

std::string CourseDesk::WhyNotTake(const Viewer& viewer, const std::string& scene) const {
  const std::string why = WhyNotAt(viewer, scene);
  // The scene may have further burs, which would cut what another's trial is graded by.
  return why.empty() && trials_.now().is_cut_in(scene) ? TrialRunsIn(scene) : why;
}

std::string CourseDesk::WhyNotRestore(const Viewer& viewer, const std::string& scene) const {
  // Not even its person or a teacher: what was cut would count no more.
  return trials_.now().is_in(scene) ? TrialRunsIn(scene) : WhyNotAt(viewer, scene);
}

}  // namespace palpate
