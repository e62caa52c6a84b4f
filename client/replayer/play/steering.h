#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "client/replayer/play/bookmarks.h"
#include "client/replayer/play/timeline.h"
#include "common/dds/cdr_reader.h"
#include "common/dds/endpoint.h"
#include "common/dds/request_memory.h"
#include "common/dds/topics.h"

namespace palpate {

/// Reports a replay's state to viewers and receives their requests (idl/replay.idl).
class Steering {
 public:
  struct State {
    double at_s = 0.0;
    double rate = 1.0;
    double sought = 1.0;
    bool playing = false;
    bool ended = false;
  };

  /// @param timeline  finished; must outlive it, as must the participant.
  /// @param locked    viewers may watch, but not steer.
  /// Throws Error if the bookmarks beside the recording cannot be read.
  Steering(const dds::Participant& service, const std::string& recording, const Timeline& timeline,
           bool locked);

  /// Returns the next play, pause, seek or rate request, in the order written; false if there is
  /// none.  Handles bookmark requests and refuses invalid ones itself.
  /// @param now  the state to report with those answers.
  bool Take(const State& now, wire::ReplayRequest& request);
  void Tell(const State& state);
  /// True once a viewer's request has been accepted.
  bool steered() const { return steered_; }

  /// Adds a bookmark set at this terminal.  Throws Error (reason, remedy).
  void AddBookmark(double at_s, const std::string& name);
  /// Returns the next bookmark or mark after at_s; none if there is none.
  std::optional<double> MarkAfter(double at_s) const;
  std::optional<double> MarkBefore(double at_s) const;

 private:
  struct Wish {
    std::int64_t time_ns;
    wire::ReplayRequest request;
  };

  double Seconds(std::int64_t time_ns) const;  ///< from the beginning
  void GatherMarks();
  void TellContents();
  void TakeWishes();
  /// Throws Error with the reason to refuse it.
  void Check(const wire::ReplayRequest& request) const;
  /// Returns true if the request was about bookmarks, which is then done.
  bool KeepBookmark(const wire::ReplayRequest& request);

  const Timeline& timeline_;
  Bookmarks bookmarks_;
  const std::string recording_;
  const bool locked_;
  const std::uint64_t replay_;
  std::uint64_t answered_ = 0;
  std::string refusal_;
  bool steered_ = false, contents_told_ = false;
  std::vector<wire::ReplayMark> marks_;  // all, by time
  std::deque<Wish> wishes_;
  RequestMemory requests_heard_;
  dds::Writer<wire::ReplayContents> contents_;
  dds::Writer<wire::ReplayState> states_;
  dds::CdrReader<wire::ReplayRequest> requests_;
};

}  // namespace palpate
