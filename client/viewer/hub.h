#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <boost/asio/io_context.hpp>

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
#include "client/viewer/viewer_places.h"
#include "client/viewer/wish_limits.h"

namespace palpate {

class ViewerSession;

/// What the gateway's connections share: the topics, the viewers, the mice, the page, and who may.
/// Thread contract: the network thread.
class Hub {
 public:
  /// Throws Error where DDS refuses, or a file of tokens is not as it should be.
  Hub(boost::asio::io_context& io, const ViewerOptions& options);

  /// Passes on what has come; 120 times a second.
  void Tick(std::int64_t now_ns);
  /// Reads --tokens and --course anew: new ones are valid, and connections whose token is gone, or
  /// has another role, end now.  A file that is not as it should be changes nothing; the log says
  /// so.
  void ReadTokensAnew(std::int64_t now_ns);
  /// Bids viewers and mice farewell; their going is seen in later ticks.
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
  /// Whether a viewer may have this wish now; empty: it may.  Where it has it too often, that is
  /// why, and the log and, once, the viewer are told.
  std::string RefuseWish(Wish wish, ViewerSession& viewer, std::int64_t now_ns);
  /// Asks the server to make a scene whole again, or what else the wish is; false where there is no
  /// such scene.
  bool AskForWhole(const std::string& scene, wire::WholeWish wish, const std::string& by);
  /// Passes a page's wish on to its replay, unless it has them too often, and makes what the page
  /// is answered.
  FramePtr AskReplay(ReplayWish wish, ViewerSession& viewer, std::int64_t now_ns);
  /// Tells all viewers, those of now and those that come later, a scene's goal, or passes on what a
  /// teacher decides about a station.  Returns why not; empty: it has.
  std::string Operate(const OperateCommand& command, const std::string& by);
  const std::map<std::string, FramePtr>& goals() const { return goals_; }
  /// Null without a --course.
  const ClassRoom* class_room() const { return class_room_.get(); }
  std::optional<Roster::Made> MakeFirstTeacher();
  /// Does what a teacher wants of the people, and makes what the page is answered.
  FramePtr Teach(const ClassCommand& command, ViewerSession& viewer);
  /// What a viewer is told of itself, and, one who may operate, of all.
  FramePtr OwnFrameOf(const ViewerSession& viewer) const;
  FramePtr PeopleFrame() const;
  /// Does what a person wants of a trial.  Returns why not; empty: it is done.
  std::string Try(const TrialCommand& command, ViewerSession& viewer, std::int64_t now_ns);
  /// What there is to do, for that person.  @param viewer  one of a course.
  FramePtr ExercisesFrameOf(const ViewerSession& viewer) const;
  /// Why somebody who sits an exam may do nothing but its tasks.
  static constexpr const char* kInExam = "an exam is open: begin its next task";
  bool SitsExam(std::int64_t person) const { return exams_ && exams_->Sits(person); }
  bool IsInExam(const ViewerSession& viewer) const;
  /// Why it may do nothing in a scene: an exam, or another's seat.  Empty: it may.
  std::string WhyNotAt(const ViewerSession& viewer, const std::string& scene) const;
  /// Does what a teacher wants of an exam, and makes what the page is answered.  Throws Error.
  FramePtr Examine(std::string_view wish, std::int64_t now_ns);
  FramePtr ExamFrameOf(const ViewerSession& viewer) const;
  /// Null without a --course.
  const TrialRoom* trials() const { return trials_.get(); }
  /// Answers what MayRead allows; 404 without a --course.
  void AskHistory(const HistoryWish& wish, bool for_teacher,
                  std::function<void(HistoryDesk::Answer)> use);
  /// Gives a viewer a tool, unless it takes them too often.
  void Take(ViewerSession& viewer, const MouseCommand& command, std::int64_t now_ns);
  MouseRoom& mice() { return mice_; }
  const std::string& session_id() const { return session_id_; }

  /// Makes room for one more viewer of this address, where it can; another may have to go for it.
  bool MakeRoom(const std::string& address);
  void Join(const std::shared_ptr<ViewerSession>& viewer);
  ViewerPlaces& places() { return places_; }
  void Leave(const ViewerSession& viewer);
  void CountSent(std::size_t bytes) {
    ++traffic_.sent;
    traffic_.bytes += bytes;
  }

  /// What GET /healthz answers.
  std::string Health() const;
  /// What GET /metrics answers, for Prometheus.
  std::string Metrics() const;

 private:
  struct Traffic {
    std::uint64_t taken = 0;  // frames
    std::uint64_t sent = 0;
    std::uint64_t bytes = 0;
    std::uint64_t lost = 0;  // of viewers that have left
  };
  void Tell(const MouseRoom::News& news);
  void Tell(const TrialRoom::News& news);
  void BeginTrial(const std::string& exercise, ViewerSession& viewer, std::int64_t now_ns);
  /// From now on these are valid, and those of the course; returns how many connections end.
  std::size_t Renew(std::optional<Tokens> tokens, std::int64_t now_ns);
  ClassRoom::Here CountPages() const;
  ClassRoom::Scenes Scenes() const;
  /// Pages of the course are told what has changed there, once a tick.
  void TellClass(std::int64_t now_ns);
  void TellExam(std::int64_t now_ns);
  /// Why a scene's tools cannot be had now; empty: they can.
  std::string WhyAbsent(const std::string& scene) const;
  void TellState(ViewerSession& viewer, const MouseRoom::News& news);
  void LogStatistics(std::int64_t now_ns);
  /// With what viewers have lost that are there.
  Traffic AllTraffic() const;

  ViewerOptions options_;
  std::unique_ptr<ClassRoom> class_room_;
  std::optional<Tokens> listed_;  // of --tokens
  std::unique_ptr<TrialRoom> trials_;
  std::unique_ptr<HistoryDesk> history_;
  std::unique_ptr<ExamRoom> exams_;
  bool class_changed_ = false;
  Gate gate_;
  RefusalLog refusals_;
  ViewerPlaces places_;
  WishLimits wishes_;
  PageFiles page_;
  TopicFeed feed_;
  std::string session_id_;
  std::map<std::string, FramePtr> goals_;                            // by scene
  std::map<std::uint64_t, std::shared_ptr<ViewerSession>> viewers_;  // by id
  MouseRoom mice_;
  ScenePacker packer_;
  Traffic traffic_;
  Traffic logged_;  // with those that are there
  std::int64_t logged_ns_ = 0;
};

}  // namespace palpate
