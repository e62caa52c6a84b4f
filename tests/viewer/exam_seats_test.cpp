// An exam whose tasks lie in three scenes, for a whole class at once, at real programs: fewer seats
// than candidates, a gateway that is killed twice, and another one that is started beside it.
//
// PALPATE_CANDIDATES and PALPATE_SEATS say how many there are, e.g. 20 and 4, and PALPATE_TASK_S
// for how many seconds each works; CI has a small class.  The figures are printed.
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "common/json/pose_script.h"
#include "common/realtime/steady_clock.h"
#include "common/realtime/wall_clock.h"
#include "common/recording/file_summary.h"
#include "tests/support/folder.h"
#include "tests/support/read_file.h"
#include "tests/viewer/course_pages.h"

namespace palpate::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExercises = PALPATE_SOURCE_DIR "/client/course/exercises/";
constexpr std::uint32_t kExamHeard = 4, kMouseHeard = 6;

int FromEnvironment(const char* name, int otherwise) {
  const char* const text = std::getenv(name);
  return text == nullptr ? otherwise : std::atoi(text);
}

/// What a candidate's page knows of the exam.
struct Standing {
  int task = 0;
  std::string phase;  // "ready", "waits", "called", "works" or "done"
};

/// A candidate's page, which does what a candidate does, in a thread of its own: begins each task,
/// follows the expert's hand for some seconds, hands in, and connects again whenever the gateway
/// has gone.
class Candidate {
 public:
  Candidate(std::string token, const std::atomic<int>& port, double works_s)
      : token_(std::move(token)), port_(port), works_s_(works_s), thread_([this] { Live(); }) {}
  ~Candidate() {
    ends_ = true;
    thread_.join();
  }
  Standing standing() const {
    const std::scoped_lock lock(guard_);
    return standing_;
  }
  /// What it knew when the gateway went, and what the next one told it first.
  std::vector<std::pair<Standing, Standing>> returns() const {
    const std::scoped_lock lock(guard_);
    return returns_;
  }
  /// The reasons for which it was refused something.
  std::vector<std::string> refusals() const {
    const std::scoped_lock lock(guard_);
    return refusals_;
  }
  bool has_waited() const { return has_waited_; }

 private:
  void Live() {
    while (!ends_) {
      if (!page_ || !page_->open()) Connect();
      if (page_ && page_->open()) Hear();
    }
  }
  void Connect() {
    const int port = port_;
    page_.reset();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    if (port == 0) return;
    page_ = std::make_unique<WebClient>(port, kV1, "", 0,
                                        Gateway::Headers{{"Authorization", "Bearer " + token_}});
    if (!page_->open()) return;
    page_->Subscribe(kMouseHeard, TopicFeed::kMouseState);
    page_->Subscribe(kExamHeard, TopicFeed::kExam);
    is_back_ = true;
    at_.clear();
    asks_ns_ = std::numeric_limits<std::int64_t>::max();
    since_ns_ = 0;
  }
  void Hear() {
    page_->Run(0.005);
    if (const auto mouse = page_->Next(kMouseHeard, 0.0)) {
      const CourseJson state = CourseJson::parse(mouse->payload);
      if (state["phase"] == "active" && since_ns_ == 0) since_ns_ = SteadyNanoseconds();
      if (state["phase"] == "refused") {
        const std::scoped_lock lock(guard_);
        refusals_.push_back(state["reason"].get<std::string>());
        asks_ns_ = SteadyNanoseconds() + 1'000'000'000;
      }
    }
    if (const auto exam = page_->Next(kExamHeard, 0.0)) {
      const CourseJson open = CourseJson::parse(exam->payload)["open"];
      if (open.is_object() && !open["closed"]) Take(open);
    }
    if (standing().phase == "works" && since_ns_ != 0) Work();
    Begin();
  }
  void Take(const CourseJson& open) {
    const Standing now{open["task"].get<int>(), open["turn"]["phase"].get<std::string>()};
    {
      const std::scoped_lock lock(guard_);
      if (std::exchange(is_back_, false) && !standing_.phase.empty()) {
        returns_.emplace_back(standing_, now);
      }
      standing_ = now;
    }
    has_waited_ = has_waited_ || now.phase == "waits";
    if (now.phase == "works") {
      exercise_ = open["exercise"]["name"];
    } else {
      since_ns_ = 0;
    }
    next_ = open.value("exercise", CourseJson::object()).value("name", "");
    const std::string at = fmt::format("{} {}", now.task, now.phase);
    if (std::exchange(at_, at) != at) asks_ns_ = SteadyNanoseconds();
  }
  /// Begins the next task, once, or again a second after it was refused.
  void Begin() {
    const std::string phase = standing().phase;
    if ((phase != "ready" && phase != "called") || SteadyNanoseconds() < asks_ns_) return;
    asks_ns_ = std::numeric_limits<std::int64_t>::max();
    page_->SendTrial({{"op", "begin"}, {"exercise", next_}});
  }
  void Work() {
    const double t = 1e-9 * static_cast<double>(SteadyNanoseconds() - since_ns_);
    if (t > works_s_) {
      since_ns_ = 0;
      return page_->SendTrial({{"op", "stop"}});
    }
    auto& path = paths_[exercise_];
    if (!path)
      path = std::make_unique<PoseScript>(PoseScript::Load(kExercises + exercise_ + ".path.json"));
    const Pose X = path->At(t);
    page_->SendMouse({{"op", "pose"},
                      {"p", {X.p.x(), X.p.y(), X.p.z()}},
                      {"q", {X.q.w(), X.q.x(), X.q.y(), X.q.z()}}});
  }

  const std::string token_;
  const std::atomic<int>& port_;
  const double works_s_;
  std::atomic<bool> ends_ = false, has_waited_ = false;
  mutable std::mutex guard_;
  Standing standing_;
  std::vector<std::pair<Standing, Standing>> returns_;
  std::vector<std::string> refusals_;
  // Of the thread alone.
  std::unique_ptr<WebClient> page_;
  bool is_back_ = false;
  std::string at_, exercise_, next_;
  std::int64_t asks_ns_ = 0;   // from when on it may begin
  std::int64_t since_ns_ = 0;  // since when it has its tool
  std::map<std::string, std::unique_ptr<PoseScript>> paths_;
  std::thread thread_;  // the last member: it uses the others
};

/// The course, its server, the gateway that keeps it, and all candidates' pages.
class ExamSeats : public testing::Test {
 protected:
  void Serve() {
    fs::create_directory(course_);
    std::ofstream(course_ + "/midterm.exam.json") << R"({"title": "Midterm", "time_s": 3600,
      "order": "rotated", "tasks": [{"exercise": "light-force"}, {"exercise": "nodule-palpation"},
      {"exercise": "supragingival-calculus"}]})";
    ASSERT_TRUE(server_.Says("ready: ", 200.0)) << server_.Output();
    StartGateway();
    link_ = FirstLink(*gateway_);
    ASSERT_TRUE(gateway_->KnowsScenes(static_cast<std::size_t>(3 * (kSeats + 1)), headers()));
  }
  void StartGateway() {
    gateway_ = std::make_unique<Gateway>(std::vector<std::string>{"--course", course_});
    port_ = gateway_->port();
  }
  void Open() {
    Teacher teacher(*gateway_, link_);
    std::vector<std::string> names;
    for (int i = 1; i <= kPeople; ++i) names.push_back(fmt::format("Student {}", i));
    const CourseJson made =
        teacher.Ask({{"op", "person_make"}, {"names", names}, {"role", "drive"}})["people"];
    teacher.client().SendExam({{"tag", 1}, {"op", "open"}, {"exam", "midterm"}});
    for (const CourseJson& person : made) {
      people_.push_back(
          std::make_unique<Candidate>(person["token"].get<std::string>(), port_, kTask_s));
    }
  }
  /// Waits, reading the programs' output: a server whose output nobody reads stops.
  bool Comes(const std::function<bool()>& what, double seconds) {
    return Eventually(
        [&] {
          server_.Output();
          gateway_->program().Output();
          return what();
        },
        seconds);
  }
  Gateway::Headers headers() const { return {{"Authorization", "Bearer " + link_}}; }
  int Count(const std::string& phase) const {
    return static_cast<int>(std::ranges::count_if(
        people_, [&](const auto& one) { return one->standing().phase == phase; }));
  }
  /// Where everybody is, and why somebody was refused.
  std::string Standings() const {
    std::string all;
    for (const auto& one : people_) {
      all += fmt::format("task {}, {}", one->standing().task, one->standing().phase);
      for (const std::string& reason : one->refusals()) all += "; " + reason;
      all += '\n';
    }
    return all + gateway_->program().Output();
  }
  /// The number of tasks that are done.
  int Done() const {
    int done = 0;
    for (const auto& one : people_) done += one->standing().task;
    return done;
  }
  /// Kills the gateway while somebody works and somebody waits, and starts the next one.
  void Kill() {
    ASSERT_TRUE(Comes([&] { return Count("works") > 0 && Count("waits") > 0; }, 60.0))
        << Standings();
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    port_ = 0;
    killed_ns_.push_back(WallClock_ns());
    gateway_->program().Signal(SIGKILL);
    EXPECT_EQ(gateway_->program().Exit(), -SIGKILL);
    StartGateway();
    const auto is_back = [&](const auto& one) {
      return one->returns().size() == killed_ns_.size();
    };
    ASSERT_TRUE(Comes([&] { return std::ranges::all_of(people_, is_back); }, 60.0));
  }
  void RefuseAnother() {
    Program second(PALPATE_BIN_DIR "/palpate-viewer",
                   {"--http", "0", "--domain", std::to_string(kDomain), "--course", course_});
    EXPECT_EQ(second.Exit(), 1);
    EXPECT_THAT(second.Output(),
                testing::HasSubstr(fmt::format("process {}", gateway_->program().id())));
  }
  void Close() {
    Teacher teacher(*gateway_, link_);
    teacher.client().SendExam({{"tag", 2}, {"op", "close"}});
    const std::string roll = course_ + "/exams/midterm-1.roll.json";
    ASSERT_TRUE(Comes(
        [&] { return ReadWholeFile(roll).find(R"("complete":true)") != std::string::npos; }, 60.0));
  }
  /// The certificate of palpate-replay verify-exam.
  CourseJson Verified() {
    Program verify(PALPATE_BIN_DIR "/palpate-replay",
                   {"verify-exam", course_, "--key", course_ + "/exam-key.pub.pem", "--out",
                    folder_ / "certificate"});
    EXPECT_EQ(verify.Exit(1200.0), 0) << verify.Output();
    return CourseJson::parse(ReadWholeFile(folder_ / "certificate/certificate.json"));
  }
  /// How long before its gateway's death a recording ends, which that cut short [s].
  double LostOf(const CourseJson& trial) const {
    const std::string file = course_ + "/" + trial["recording"].get<std::string>();
    std::int64_t last_ns = 0;
    for (const auto& [name, topic] : Summarise({file}).topics) {
      last_ns = std::max(last_ns, topic.last_ns);
    }
    if (last_ns == 0) return 0.0;  // it was killed before the first pose
    const auto killed_ns = std::ranges::lower_bound(killed_ns_, last_ns - 1'000'000'000);
    return killed_ns == killed_ns_.end() ? -1.0 : 1e-9 * static_cast<double>(*killed_ns - last_ns);
  }

  const int kPeople = FromEnvironment("PALPATE_CANDIDATES", 4);
  const int kSeats = FromEnvironment("PALPATE_SEATS", 1);
  const int kTask_s = FromEnvironment("PALPATE_TASK_S", 2);
  const Folder folder_;
  const std::string course_ = folder_ / "course";
  std::string link_;
  std::atomic<int> port_ = 0;
  std::vector<std::int64_t> killed_ns_;
  Program server_{PALPATE_BIN_DIR "/palpate-server",
                  {"periodontal", kExercises + std::string("hidden-nodule.json"), "calculus",
                   "--seats", std::to_string(kSeats), "--realtime", "off", "--transport", "udp",
                   "--domain", std::to_string(kDomain)}};
  std::unique_ptr<Gateway> gateway_;
  std::vector<std::unique_ptr<Candidate>> people_;
};

TEST_F(ExamSeats, LetsAClassDoTasksInThreeScenesAtOnceThoughItsGatewayIsKilled) {
  Serve();
  if (HasFatalFailure()) return;
  Open();
  Kill();
  if (HasFatalFailure()) return;
  RefuseAnother();
  ASSERT_TRUE(Comes([&] { return Done() >= kPeople; }, 30.0 * kPeople));
  Kill();
  if (HasFatalFailure()) return;
  ASSERT_TRUE(Comes([&] { return Count("done") == kPeople; }, 60.0 * kPeople));
  Close();
  if (HasFatalFailure()) return;

  bool has_waited = false;
  for (const auto& one : people_) {
    // The next gateway hears of the server some moments later.
    EXPECT_THAT(one->refusals(), testing::Each(testing::HasSubstr("no server")));
    has_waited = has_waited || one->has_waited();
    for (const auto& [before, after] : one->returns()) {
      // A trial that ran is over, and counts: its person is at the next task.
      EXPECT_GE(after.task, before.task);
      EXPECT_LE(after.task, before.task + 1);
      if (before.phase == "waits") {
        EXPECT_EQ(after.task, before.task);
        EXPECT_THAT(after.phase, testing::AnyOf("waits", "called"));
      }
      if (before.phase == "done") EXPECT_EQ(after.phase, "done");
    }
  }
  EXPECT_TRUE(has_waited);
  const CourseJson certificate = Verified();
  EXPECT_EQ(certificate["good"], true);
  EXPECT_EQ(certificate["trials"].size(), static_cast<std::size_t>(3 * kPeople));
  int cut = 0;
  double lost_s = 0.0, recorded_s = 0.0;
  for (const CourseJson& trial : certificate["trials"]) {
    EXPECT_EQ(trial["refused"], "") << trial["recording"];
    recorded_s += trial["recorded_s"].get<double>();
    if (trial["whole"]) continue;
    ++cut;
    EXPECT_EQ(trial["reason"], "the gateway was killed");
    if (trial["recording"] != "") lost_s = std::max(lost_s, LostOf(trial));
  }
  std::cout << fmt::format(
      "{} candidates, {} seats a scene: {} trials verified in {:.1f} s, {:.0f} s recorded; {} cut "
      "short by two kills, of which at most {:.2f} s are lost\n",
      kPeople, kSeats, certificate["trials"].size(), certificate["took_s"].get<double>(),
      recorded_s, cut, lost_s);
}

}  // namespace
}  // namespace palpate::test
