#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "common/dds/endpoint.h"
#include "common/dds/topics.h"
#include "common/program/stop_signal.h"
#include "common/recording/recorded_type.h"

namespace palpate {

/// Publishes as a server: owns the writers that viewers listen to.
class Voice {
 public:
  /// Both must outlive it.
  Voice(const dds::Participant& service, StopSignal& stop);

  /// Starts a round: what follows appears to come from another server, so viewers reset their
  /// scenes and tools.  Call it before the first sample, too.
  void BeginRound();
  /// Publishes a sample.  A sample that stays is retried until viewers have taken it, even for
  /// seconds.  Returns false if the replay is stopped meanwhile.
  bool Say(RecordedType type, std::span<const std::uint8_t> cdr);
  /// Ends every open session.
  void EndSessions(const std::string& reason);
  bool has_session(const std::string& station) const { return standing_.contains(station); }
  /// True if viewers missed a sample in this round, so that their picture is incomplete.
  bool lacks() const { return lacks_; }

 private:
  /// The writers of states that stay.  DDS keeps their samples for viewers that come later, who
  /// must not receive those of a former round, so each round has its own writers.
  struct Round {
    explicit Round(const dds::Participant& service);
    dds::Writer<wire::SessionState> states;
    dds::Writer<wire::SolidBlock> blocks;
    dds::Writer<wire::SceneWhole> wholes;
    dds::Writer<wire::SceneBundle> bundles;
  };

  template <class T>
  bool Say(std::span<const std::uint8_t> cdr, dds::Writer<T>& writer, bool stays);
  template <class T>
  bool Insist(dds::Writer<T>& writer, const T& value);
  void Keep(const wire::SessionState& state);

  const dds::Participant& service_;
  StopSignal& stop_;
  std::uint64_t run_ = 0;
  bool lacks_ = false;
  std::map<std::string, wire::SessionState> standing_;
  std::optional<Round> round_;
  dds::Writer<wire::ToolState> tools_;
  dds::Writer<wire::MovedState> moved_;
  dds::Writer<wire::LoopStatistics> statistics_;
  dds::Writer<wire::StationStatistics> stations_;
};

}  // namespace palpate
