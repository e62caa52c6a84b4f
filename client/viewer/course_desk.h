#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <boost/asio/io_context.hpp>

#include "client/course/exam_clock.h"
#include "client/course/exam_room.h"
#include "client/course/trial.h"
#include "client/viewer/history_desk.h"
#include "client/viewer/mouse_room.h"
#include "client/viewer/rights.h"
#include "client/viewer/topic_feed.h"

namespace palpate {

/// The course within the gateway: what the pages of its people may ask and are told of class,
/// exercises, trials, exams and history.
/// Thread contract: the network thread.
class CourseDesk {
 public:
  /// @param rights  with a class.   Throws Error.
  CourseDesk(boost::asio::io_context& io, const ViewerOptions& options, Viewers& viewers,
             TopicFeed& feed, MouseRoom& mice, Rights& rights);

  TrialRoom& trials() { return trials_; }
  /// Returns the frame of a channel of the course that a new subscriber must get first; null: none.
  FramePtr Kept(std::uint32_t channel, const Viewer& viewer);
  /// A viewer has joined.
  void Enter(const Viewer& viewer);
  /// Pages are told of the class again at the next tick.
  void NoteChange() { changed_ = true; }
  void Tick(std::int64_t now_ns);

  /// Carries out a teacher's command about people.  Returns the answer for the page.
  FramePtr Teach(const ClassCommand& command, Viewer& viewer);
  /// Carries out a teacher's command about exams.  Returns the answer for the page.  Throws Error.
  FramePtr Examine(std::string_view wish, std::int64_t now_ns);
  /// Carries out a person's command about a trial.  Returns why it failed; empty: it is done.
  std::string Try(const TrialCommand& command, Viewer& viewer, std::int64_t now_ns);
  /// Answers a request that MayRead allows.
  void AskHistory(const HistoryWish& wish, bool for_teacher,
                  std::function<void(HistoryDesk::Answer)> use);

  /// Returns why somebody who sits an exam may do nothing but its tasks; empty: they sit none.
  std::string WhyNotInExam(std::int64_t person) const;
  /// Returns why the viewer may take no tool in a scene, an exam or another's seat; empty: it may.
  std::string WhyNotTake(const Viewer& viewer, const std::string& scene) const;
  /// Likewise why it may not restore a scene, or set its bookmark.
  std::string WhyNotRestore(const Viewer& viewer, const std::string& scene) const;

 private:
  std::string WhyNotAt(const Viewer& viewer, const std::string& scene) const;
  bool IsInExam(const Viewer& viewer) const { return exams_.Sits(viewer.guest().person()); }
  /// Names of the viewers that hold tools, by station.
  std::map<std::string, std::string> NamesAtTools() const;
  FramePtr OwnFrameOf(const Viewer& viewer) const;
  FramePtr PeopleFrame();
  FramePtr ExercisesFrameOf(const Viewer& viewer);
  FramePtr ExamFrameOf(const Viewer& viewer) const;
  void ForEachPage(const std::function<void(Viewer&)>& action) const;
  void Tell(const TrialRoom::News& news);
  void BeginTrial(const TrialCommand& command, Viewer& viewer, std::int64_t now_ns);
  /// Returns the seat of a trial that is no exam's.  Throws Error, worded for the person, if they
  /// cannot begin there.
  std::string SeatForPractice(const Exercise& exercise, const Viewer& viewer) const;
  /// Returns whether all scenes of the server have been heard; just after a start some have not.
  bool KnowsScenes() const;
  /// Returns the seats of a scene in which a candidate of the exam may begin now, or the scene
  /// itself if it has no seats; first their own.
  std::vector<std::string> FreeSeats(std::int64_t person, const std::string& scene) const;
  ClassRoom::Here CountPages() const;

  Viewers& viewers_;
  TopicFeed& feed_;
  MouseRoom& mice_;
  Rights& rights_;
  ClassRoom& class_room_;
  const std::string prefix_;  // of stations that are named after tokens
  TrialRoom trials_;
  HistoryDesk history_;
  ExamClock exam_clock_;
  ExamRoom exams_;
  const ExamTurns::Seats exam_seats_;
  std::int64_t called_ns_ = 0;  // when seats of an exam were given last
  std::size_t scenes_heard_ = 0;
  std::int64_t scenes_heard_ns_;  // when that number last changed, or this began
  bool changed_ = false;
  std::map<std::int64_t, TrialRoom::News> newest_trials_;  // by person
};

}  // namespace palpate
