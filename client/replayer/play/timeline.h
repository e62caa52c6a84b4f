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

/// True for what viewers see.
bool IsForViewers(RecordedType type);
/// True for what of it holds on once it is said; the rest streams, and the next takes its place.
bool Stays(RecordedType type);

/// A recording by time: what holds for viewers at any moment of it, where in its files to read on
/// from there, what took place in it, and where it has nothing.  Made by one pass over all of it;
/// then to go to a moment costs a look through the states that were told up to it (sessions,
/// scenes, and each block that was cut), and at most a few seconds of the files.
///
/// A sample's turn is its time, or that of the latest before it where a recording's times go back:
/// times below are turns.
class Timeline {
 public:
  /// Who says something that streams.
  using Source = std::pair<RecordedType, std::string>;
  /// A source that has said nothing for longer is quiet: statistics come once a second.
  static constexpr std::int64_t kQuiet_ns = 1'100'000'000;
  static Source SourceOf(const RecordedSample& sample);

  /// A sample that holds until another one of its key comes.
  struct State {
    RecordedType type;
    std::int64_t time_ns;
    std::uint64_t server_run;
    std::string name;      ///< station or scene
    std::uint64_t number;  ///< a change's of the scene; a SceneWhole's last change; else 0
    std::uint64_t place;   ///< of what there are several of a name: which; else 0
    std::vector<std::uint8_t> cdr;
  };
  /// What viewers know who have heard all up to a time: of one server's run, each key's last state,
  /// without the changes that are undone.  A function of recording and time alone.
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
  /// Where to read on, and the latest turn of all samples before.
  struct Start {
    std::int64_t passed_ns;
    RecordingReader::Place place;
  };
  /// More marks or gaps no list shows, and no message should hold.
  static constexpr std::size_t kMost = 400;

  /// @param passed_ns  the turn of the sample before.
  static std::int64_t TurnOf(const RecordedSample& sample, std::int64_t passed_ns);

  /// @param place  the reader's, of this sample.
  /// Throws Error where a scene's bundle is not the one that its hash names.
  void Add(const RecordedSample& sample, const RecordingReader::Place& place);
  /// No more samples come.
  void Finish();

  std::int64_t first_ns() const { return first_ns_; }
  std::int64_t last_ns() const { return last_ns_; }
  /// When the scenes are there that the recorder was told of as it began: before, nothing can be
  /// shown.
  std::int64_t opening_ns() const { return opening_ns_; }
  std::uint64_t for_viewers() const { return for_viewers_; }

  Moment At(std::int64_t time_ns) const;
  /// A place before all samples from `time_ns` on.
  Start StartFor(std::int64_t time_ns) const;
  /// The sources that are quiet at a time, and when each last said something.
  std::vector<std::pair<Source, std::int64_t>> QuietAt(std::int64_t time_ns) const;
  const std::vector<Mark>& marks() const { return marks_; }  ///< by time
  const std::vector<Gap>& gaps() const { return gaps_; }     ///< by time
  /// Marks and gaps that there was no room for.
  std::uint64_t left_out() const { return left_out_; }

 private:
  /// What a source says when, but for the times between that are shorter than kQuiet_ns.
  struct Speech {
    std::int64_t last_ns = 0;
    std::vector<std::pair<std::int64_t, std::int64_t>> quiet;  // from and to, by time
  };
  /// What a station has been seen to do, for marks and gaps.
  struct Station {
    bool any = false;
    std::int64_t tool_ns = 0;  // its last ToolState, or where the recording begins
    std::uint64_t poses = 0;   // since then
    std::string ended;         // why it had no session at some time since then
    std::uint64_t run = 0;     // of the session that it has, or had last
    std::string over;          // why it has none now
    bool has_touched = false, touches = false;
    std::int64_t touched_ns = 0;
    std::uint32_t faults = 0;
    bool has_failed = false;
    std::int64_t failed_ns = 0;
  };

  /// False where it says again what holds.
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
  std::map<Moment::Key, std::size_t> last_;  // into states_
  std::vector<Start> starts_;
  std::map<Source, Speech> speeches_;
  std::map<std::string, Station> stations_;
  std::map<std::string, std::string> station_of_;                // by a pose topic's name
  std::set<std::pair<std::string, std::uint64_t>> begun_;        // sessions that have a mark
  std::vector<std::pair<std::int64_t, std::int64_t>> silences_;  // no sample at all
  std::vector<Mark> marks_;
  std::vector<Gap> gaps_;
  std::int64_t first_ns_ = 0, last_ns_ = 0, opening_ns_ = 0;
  std::uint64_t for_viewers_ = 0, left_out_ = 0;
  bool any_ = false;
};

/// True where viewers who were told `told` can be told the rest of `wanted`.  Else they have to
/// forget first, as they do where another server's run begins: only so does come back what has been
/// cut, and goes what was not there yet.
bool LeadsTo(const Timeline::Moment& told, const Timeline::Moment& wanted);

/// What of `wanted` is not in `told`, in the recording's order.
std::vector<const Timeline::State*> RestOf(const Timeline::Moment& wanted,
                                           const Timeline::Moment& told);

}  // namespace palpate
