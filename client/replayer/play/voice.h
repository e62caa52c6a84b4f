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

/// Speaks as a server: the writers that viewers listen to.
class Voice {
 public:
  /// Both must outlive it.
  Voice(const dds::Participant& service, StopSignal& stop);

  /// What comes from here on is another server's, which viewers take for a new one: its scenes are
  /// whole again, and nobody holds a tool.  Before the first word, too.
  void BeginRound();
  /// Says a sample that stays until viewers have taken it, be it for seconds.  False where the
  /// replay is stopped meanwhile.
  bool Say(RecordedType type, std::span<const std::uint8_t> cdr);
  /// Ends every session that stands.
  void EndSessions(const std::string& reason);
  bool has_session(const std::string& station) const { return standing_.contains(station); }
  /// True where viewers did not take something in this round, and lack it in their picture.
  bool lacks() const { return lacks_; }

 private:
  /// The writers of what stays.  DDS keeps it for viewers that come later, and of a former round
  /// they must hear nothing: so each round has its own.
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
  dds::Writer<wire::LoopStatistics> statistics_;
  dds::Writer<wire::StationStatistics> stations_;
};

}  // namespace palpate
