#pragma once

#include <cstdint>
#include <string>

#include "client/viewer/course_desk.h"
#include "client/viewer/mouse_room.h"
#include "client/viewer/topic_feed.h"
#include "client/viewer/viewers.h"

namespace palpate {

/// What viewers do in a scene: take a tool with the mouse, lose it, come back to it, restore what
/// was cut.
/// Thread contract: the network thread.
class ToolDesk {
 public:
  /// @param course  null without --course.
  ToolDesk(Viewers& viewers, TopicFeed& feed, MouseRoom& mice, CourseDesk* course)
      : viewers_(viewers), feed_(feed), mice_(mice), course_(course) {}

  MouseRoom& mice() { return mice_; }
  /// Gives a viewer a tool, unless it takes tools too often.
  void Take(Viewer& viewer, const MouseCommand& command, std::int64_t now_ns);
  /// Restores a scene, or keeps its state for that.
  void Restore(Viewer& viewer, const MouseCommand& command, std::int64_t now_ns);
  /// A viewer has gone, or says nothing more: its running trial and the tool wait for it.
  void Miss(std::uint64_t id, const std::string& reason, std::int64_t now_ns);
  /// Gives a person's page the trial and the tool of the one that has gone.
  void Return(const Viewer& viewer, std::int64_t now_ns);

  void Hear(const MouseRoom::News& news);
  /// Ends the trials of a scene that somebody has restored past this gateway, or that could not be
  /// restored for them.
  void Hear(const wire::SceneWhole& whole, bool is_own);

 private:
  Viewers& viewers_;
  TopicFeed& feed_;
  MouseRoom& mice_;
  CourseDesk* const course_;
};

}  // namespace palpate
