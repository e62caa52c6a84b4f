#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <boost/asio/io_context.hpp>

#include "client/course/exam_clock.h"
#include "client/course/exam_room.h"
#include "client/course/trial.h"
#include "client/viewer/class_room.h"
#include "client/viewer/gate.h"
#include "client/viewer/history_desk.h"
#include "client/viewer/mouse_room.h"
#include "client/viewer/options.h"
#include "client/viewer/page_files.h"
#include "client/viewer/page_messages.h"
#include "client/viewer/refusal_log.h"
#include "client/viewer/scene_packer.h"
#include "client/viewer/topic_feed.h"
#include "client/viewer/viewer.h"
#include "client/viewer/viewer_places.h"
#include "client/viewer/wish_limits.h"

namespace palpate {

/// The state that the gateway's connections share: topics, viewers, mouse stations, page files,
/// and access rights.
/// Thread contract: the network thread.
class Hub {
 public:
  /// Throws Error if DDS fails or a token file is invalid.
  Hub(boost::asio::io_context& io, const ViewerOptions& options);

  /// Distributes what has arrived; to be called 120 times a second.
  void Tick(std::int64_t now_ns);
  /// Reads --tokens and --course again.  New tokens are valid from now on; connections whose token
  /// was removed or has another role end.  An invalid file changes nothing and is logged.
  void ReadTokensAnew(std::int64_t now_ns);
  /// Begins to close viewers and mouse stations; later ticks complete it.
  void BeginToEnd(std::int64_t now_ns);
  bool ended() const {
    return viewers_.empty() && mice_.size() == 0 && (!trials_ || trials_->size() == 0);
  }

  const ViewerOptions& options() const { return options_; }
  PageFiles& page() { return page_; }
  const TopicFeed& feed() const { return feed_; }
  const Gate& gate() const { return gate_; }
  RefusalLog& refusals() { return refusals_; }
  ScenePacker& packer() { return packer_; }
  /// Returns why a viewer may not have this wish now; empty: it may.  A wish that comes too often
  /// is logged, and the viewer is told once.
  std::string RefuseWish(Wish wish, Viewer& viewer, std::int64_t now_ns);
  /// Asks the server to restore a scene, or for another WholeWish.  Returns false if there is
  /// no such scene.
  bool AskForWhole(const std::string& scene, wire::WholeWish wish, const std::string& by);
  /// Forwards a page's wish to its replay, unless wishes come too often.  Returns the answer
  /// for the page.
  FramePtr AskReplay(ReplayWish wish, Viewer& viewer, std::int64_t now_ns);
  /// Sets a scene's goal, which all present and later viewers are told, or forwards a teacher's
  /// decision about a station.  Returns why it failed; empty: it is done.
  std::string Operate(const OperateCommand& command, const std::string& by);
  const std::map<std::string, FramePtr>& goals() const { return goals_; }
  /// Tells another gateway that is started for the same course where this one serves it.
  void NoteAddress(const std::string& urls);
  /// Null without --course.
  const ClassRoom* class_room() const { return class_room_.get(); }
  std::optional<Roster::Made> MakeFirstTeacher();
  /// Carries out a teacher's command about people.  Returns the answer for the page.
  FramePtr Teach(const ClassCommand& command, Viewer& viewer);
  /// What a viewer is told about itself, and what an operator is told about all people.
  FramePtr OwnFrameOf(const Viewer& viewer) const;
  FramePtr PeopleFrame() const;
  /// Carries out a person's command about a trial.  Returns why it failed; empty: it is done.
  std::string Try(const TrialCommand& command, Viewer& viewer, std::int64_t now_ns);
  /// The exercises, for a person's page.  @param viewer  one with a person of the course.
  FramePtr ExercisesFrameOf(const Viewer& viewer) const;
  /// Why somebody who sits an exam may do nothing but its tasks.
  static constexpr const char* kInExam = "an exam is open: begin its next task";
  bool SitsExam(std::int64_t person) const { return exams_ && exams_->Sits(person); }
  bool IsInExam(const Viewer& viewer) const;
  /// Returns why the viewer may do nothing in a scene, an exam or another's seat; empty: it may.
  std::string WhyNotAt(const Viewer& viewer, const std::string& scene) const;
  /// Likewise why it may not restore a scene, or set its bookmark.
  std::string WhyNotRestore(const Viewer& viewer, const std::string& scene) const;
  /// Carries out a teacher's command about exams.  Returns the answer for the page.  Throws Error.
  FramePtr Examine(std::string_view wish, std::int64_t now_ns);
  FramePtr ExamFrameOf(const Viewer& viewer) const;
  /// Null without --course.
  const TrialRoom* trials() const { return trials_.get(); }
  /// Answers a request that MayRead allows; 404 without --course.
  void AskHistory(const HistoryWish& wish, bool for_teacher,
                  std::function<void(HistoryDesk::Answer)> use);
  /// Gives a viewer a tool, unless it takes tools too often.
  void Take(Viewer& viewer, const MouseCommand& command, std::int64_t now_ns);
  MouseRoom& mice() { return mice_; }
  const std::string& session_id() const { return session_id_; }

  /// Returns whether there is room for one more viewer of this address; another may be
  /// dropped for it.
  bool MakeRoom(const std::string& address);
  void Join(const std::shared_ptr<Viewer>& viewer);
  ViewerPlaces& places() { return places_; }
  void Leave(const Viewer& viewer);
  /// A viewer has gone, or says nothing more: its running trial and the tool wait for it.
  void Miss(std::uint64_t id, const std::string& reason, std::int64_t now_ns);
  /// Gives a person's page the trial and the tool of the one that has gone.
  void Return(const Viewer& viewer, std::int64_t now_ns);
  void CountSent(std::size_t bytes) {
    ++traffic_.sent;
    traffic_.bytes += bytes;
  }

  /// The answer to GET /healthz.
  std::string Health() const;
  /// The answer to GET /metrics, for Prometheus.
  std::string Metrics() const;

 private:
  /// Names of the viewers that hold tools, by station.
  std::map<std::string, std::string> NamesAtTools() const;
  struct Traffic {
    std::uint64_t taken = 0;  // frames
    std::uint64_t sent = 0;
    std::uint64_t bytes = 0;
    std::uint64_t lost = 0;  // of viewers that have left
  };
  /// Ends the trials of a scene that somebody has restored past this gateway, or that could not be
  /// restored for them.
  void HearOfWhole(const wire::SceneWhole& whole);
  void Tell(const MouseRoom::News& news);
  void Tell(const TrialRoom::News& news);
  void BeginTrial(const TrialCommand& command, Viewer& viewer, std::int64_t now_ns);
  /// Returns the seat of a trial that is no exam's.  Throws Error, worded for the person, if they
  /// cannot begin there.
  std::string SeatForPractice(const Exercise& exercise, const Viewer& viewer) const;
  /// Returns whether all scenes of the server have been heard; just after a start some have not.
  bool KnowsScenes() const;
  /// Returns the seats of a scene in which a candidate of the exam may begin now, or the scene
  /// itself if it has no seats; first the one in which they worked last, then their own.
  std::vector<std::string> FreeSeats(std::int64_t person, const std::string& scene) const;
  /// Makes these tokens, with the course's, the valid ones.  Returns how many connections end.
  std::size_t Renew(std::optional<Tokens> tokens, std::int64_t now_ns);
  ClassRoom::Here CountPages() const;
  ClassRoom::Scenes Scenes() const;
  /// Updates pages of the course about changes, once a tick.
  void TellClass(std::int64_t now_ns);
  void TellExam(std::int64_t now_ns);
  /// Returns why a scene's tools are not available now; empty: they are.
  std::string WhyAbsent(const std::string& scene) const;
  void TellState(Viewer& viewer, const MouseRoom::News& news);
  void LogStatistics(std::int64_t now_ns);
  /// Includes the losses of viewers that are connected.
  Traffic AllTraffic() const;

  ViewerOptions options_;
  std::unique_ptr<ClassRoom> class_room_;
  std::optional<Tokens> listed_;  // of --tokens
  std::unique_ptr<TrialRoom> trials_;
  std::unique_ptr<HistoryDesk> history_;
  ExamClock exam_clock_;
  std::unique_ptr<ExamRoom> exams_;
  ExamTurns::Seats exam_seats_;
  std::int64_t called_ns_ = 0;  // when seats of an exam were given last
  std::size_t scenes_heard_ = 0;
  std::int64_t scenes_heard_ns_ = 0;  // when that number last changed, or this began
  bool class_changed_ = false;
  std::map<std::int64_t, TrialRoom::News> newest_trials_;  // by person
  Gate gate_;
  RefusalLog refusals_;
  ViewerPlaces places_;
  WishLimits wishes_;
  PageFiles page_;
  TopicFeed feed_;
  std::string session_id_;
  std::deque<std::uint64_t> own_wishes_;                      // the last requests to restore scenes
  std::map<std::string, FramePtr> goals_;                     // by scene
  std::map<std::uint64_t, std::shared_ptr<Viewer>> viewers_;  // by id
  MouseRoom mice_;
  ScenePacker packer_;
  Traffic traffic_;
  Traffic logged_;  // includes connected viewers
  std::int64_t logged_ns_ = 0;
};

}  // namespace palpate
