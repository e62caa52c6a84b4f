#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "common/dds/wire.h"
#include "common/recording/recording_reader.h"

namespace palpate {

/// Returns whether viewers receive this type.
bool IsForViewers(RecordedType type);
/// Returns whether a sample of this type for viewers stays valid until replaced (state); the others
/// are streams, in which each sample supersedes the last.
bool Stays(RecordedType type);

/// An index of a recording by time: the state that holds for viewers at any moment, where in the
/// files to continue reading, notable events (marks) and gaps.  It is built by one pass over the
/// recording.  A seek then costs a scan of the states up to that moment (sessions, scenes, and each
/// block that was cut), and at most a few seconds of the files.
///
/// A sample's turn is its time, or the latest time before it if the recording's times decrease.
/// All times below are turns.
class Timeline {
 public:
  /// The source of a stream: type and name.
  using Source = std::pair<RecordedType, std::string>;
  /// A source that has sent nothing for longer is quiet: statistics come once a second.
  static constexpr std::int64_t kQuiet_ns = 1'100'000'000;
  static Source SourceOf(const RecordedSample& sample);

  /// A sample that holds until another one with its key comes.
  struct State {
    RecordedType type;
    std::int64_t time_ns;
    std::uint64_t server_run;
    std::string name;      ///< station or scene
    std::uint64_t number;  ///< SolidBlock's change, or SceneWhole's last change; otherwise 0
    std::uint64_t place;   ///< index if a name has several; otherwise 0
    std::vector<std::uint8_t> cdr;
  };
  /// What viewers know who have received everything up to a time: the last state of each key, of
  /// one server's run, without changes that were undone.  It depends on the recording and the
  /// time only.
  struct Moment {
    using Key = std::tuple<RecordedType, std::string, std::uint64_t>;
    std::uint64_t server_run = 0;
    std::map<Key, const State*> holds;
    const State* WholeOf(const std::string& scene) const;
  };
  struct Mark {
    std::int64_t time_ns;
    palpate_ReplayMarkKind kind;
    std::string text;
  };
  struct Gap {
    std::int64_t from_ns, to_ns;
    std::string station, reason;
  };
  /// A place to continue reading, and the latest turn of all samples before it.
  struct Start {
    std::int64_t passed_ns;
    RecordingReader::Place place;
  };
  /// Largest number of marks, and of gaps: more fit into no list or message.
  static constexpr std::size_t kMost = 400;

  /// @param passed_ns  the turn of the previous sample.
  static std::int64_t TurnOf(const RecordedSample& sample, std::int64_t passed_ns);

  /// @param place  the reader's place of this sample.
  /// Throws Error if a scene's bundle does not match its hash.
  void Add(const RecordedSample& sample, const RecordingReader::Place& place);
  /// Call it after the last sample.
  void Finish();

  std::int64_t first_ns() const { return first_ns_; }
  std::int64_t last_ns() const { return last_ns_; }
  /// Returns when the scenes that the recorder received at its start are complete; nothing can be
  /// shown before.
  std::int64_t opening_ns() const { return opening_ns_; }
  std::uint64_t for_viewers() const { return for_viewers_; }

  Moment At(std::int64_t time_ns) const;
  /// Returns a place before all samples from `time_ns` on.
  Start StartFor(std::int64_t time_ns) const;
  /// Returns the sources that are quiet at a time, and when each last sent something.
  std::vector<std::pair<Source, std::int64_t>> QuietAt(std::int64_t time_ns) const;
  const std::vector<Mark>& marks() const { return marks_; }  ///< by time
  const std::vector<Gap>& gaps() const { return gaps_; }     ///< by time
  /// Returns the number of marks and gaps that did not fit.
  std::uint64_t left_out() const { return left_out_; }

 private:
  /// The activity of a source: only pauses longer than kQuiet_ns are stored.
  struct Speech {
    std::int64_t last_ns = 0;
    std::vector<std::pair<std::int64_t, std::int64_t>> quiet;  // from and to, by time
  };
  /// The observed state of a station, for marks and gaps.
  struct Station {
    bool any = false;
    std::int64_t tool_ns = 0;  // its last ToolState, or the recording's beginning
    std::uint64_t poses = 0;   // since then
    std::string ended;         // why it had no session at some time since then
    std::uint64_t run = 0;     // of its present or last session
    std::string over;          // why it has no session now
    bool has_touched = false, touches = false;
    std::int64_t touched_ns = 0;
    std::uint32_t faults = 0;
    bool has_failed = false;
    std::int64_t failed_ns = 0;
  };

  /// Returns false if the sample repeats the present state.
  bool Keep(const RecordedSample& sample, std::uint64_t server_run, const std::string& name,
            std::uint64_t number, std::uint64_t place = 0);
  void Hear(const RecordedSample& sample);
  Station& StationOf(const std::string& name);
  void AddSession(const RecordedSample& sample);
  void AddBlock(const RecordedSample& sample);
  void AddWhole(const RecordedSample& sample);
  void AddBundle(const RecordedSample& sample);
  void AddTool(const RecordedSample& sample);
  void AddPose(const std::string& topic);
  void Touch(const std::string& name, Station& station, bool touches);
  void Fail(const std::string& name, Station& station, std::uint32_t faults);
  void CloseGap(const std::string& name, Station& station);
  std::string ReasonOf(const Station& station) const;
  void AddMark(palpate_ReplayMarkKind kind, std::string text);

  std::vector<State> states_;                // in the recording's order
  std::map<Moment::Key, std::size_t> last_;  // index into states_
  std::vector<Start> starts_;
  std::map<Source, Speech> speeches_;
  std::map<std::string, Station> stations_;
  std::map<std::string, std::string> station_of_;                // by a pose topic's name
  std::set<std::pair<std::string, std::uint64_t>> begun_;        // sessions that have a mark
  std::vector<std::pair<std::int64_t, std::int64_t>> silences_;  // no sample of any source
  std::vector<Mark> marks_;
  std::vector<Gap> gaps_;
  std::int64_t first_ns_ = 0, last_ns_ = 0, opening_ns_ = 0;
  std::uint64_t for_viewers_ = 0, left_out_ = 0;
  bool any_ = false;
};

/// Returns true if viewers in the state `told` can be brought to `wanted` by further samples alone.
/// If not, they have to forget first, as when another server's run begins, since nothing else
/// restores cut material or removes what did not exist yet.
bool LeadsTo(const Timeline::Moment& published, const Timeline::Moment& wanted);

/// Returns the states of `wanted` that are not in `told`, in the recording's order.
std::vector<const Timeline::State*> RestOf(const Timeline::Moment& wanted,
                                           const Timeline::Moment& published);

}  // namespace palpate
