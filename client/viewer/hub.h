#pragma once

#include <cstdint>
#include <memory>

#include <boost/asio/io_context.hpp>

#include "client/viewer/course_desk.h"
#include "client/viewer/options.h"
#include "client/viewer/report.h"
#include "client/viewer/rights.h"
#include "client/viewer/server_desk.h"
#include "client/viewer/tool_desk.h"
#include "client/viewer/viewers.h"

namespace palpate {

/// The parts of the gateway that its connections share, and what joins them: each tick, and each
/// viewer that comes or goes.  A part knows only of those above it:
///   Viewers     who is connected: places, limits of wishes, refusals, traffic
///   Rights      who may come in: tokens, and the course's people
///   TopicFeed   the servers' topics and scenes, and requests to the server
///   CourseDesk  class, exercises, trials, exams, history: what a person's page may ask
///   ToolDesk    who takes, loses and comes back to a tool, and restores a scene
///   ServerDesk  replays, decisions about stations, goals
/// Thread contract: the network thread.
class Hub {
 public:
  /// Throws Error if DDS fails or a file is invalid.
  Hub(boost::asio::io_context& io, const ViewerOptions& options);

  const ViewerOptions& options() const { return options_; }
  Viewers& viewers() { return viewers_; }
  TopicFeed& feed() { return feed_; }
  Rights& rights() { return rights_; }
  ServerDesk& server() { return server_; }
  ToolDesk& tools() { return tools_; }
  /// Null without --course.
  CourseDesk* course() { return course_.get(); }

  void Join(const std::shared_ptr<Viewer>& viewer);
  void Leave(const Viewer& viewer);
  /// Distributes what has arrived; to be called 120 times a second.  Returns whether there is still
  /// a viewer, a mouse station or a trial.
  bool Tick(std::int64_t now_ns);
  /// Reads --tokens and --course again (Rights::ReadAnew).
  void ReadTokensAnew();
  /// Begins to close viewers and mouse stations; later ticks complete it.
  void BeginToEnd(std::int64_t now_ns);

 private:
  MouseRoom::Options MouseOptions();

  const ViewerOptions options_;
  Viewers viewers_;
  Rights rights_;
  TopicFeed feed_;
  MouseRoom mice_;
  std::unique_ptr<CourseDesk> course_;
  ToolDesk tools_;
  ServerDesk server_;
  StatisticsLog statistics_;
};

}  // namespace palpate
