#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "client/viewer/page_messages.h"
#include "client/viewer/topic_feed.h"
#include "client/viewer/viewers.h"

namespace palpate {

/// What viewers ask of servers and replays, and the goals that a teacher sets for their scenes.
/// Thread contract: the network thread.
class ServerDesk {
 public:
  ServerDesk(Viewers& viewers, TopicFeed& feed) : viewers_(viewers), feed_(feed) {}

  /// Forwards a page's wish to its replay, unless wishes come too often.  Returns the answer
  /// for the page.
  FramePtr AskReplay(ReplayWish wish, Viewer& viewer, std::int64_t now_ns);
  /// Sets a scene's goal, which all present and later viewers are told, or forwards a teacher's
  /// decision about a station.  Returns why it failed; empty: it is done.
  std::string Operate(const OperateCommand& command, const std::string& by);
  /// By scene.
  const std::map<std::string, FramePtr>& goals() const { return goals_; }

 private:
  Viewers& viewers_;
  TopicFeed& feed_;
  std::map<std::string, FramePtr> goals_;
};

}  // namespace palpate
