#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/dds/cdr.h"
#include "common/mcap/mcap_reader.h"
#include "common/recording/recorded_type.h"

namespace palpate {

/// A sample in a recording; valid until the reader's next call.
struct RecordedSample {
  RecordedType type;
  const std::string* topic;
  std::int64_t log_time_ns;
  std::span<const std::uint8_t> cdr;

  /// Converts to a T; false if the sample has another type, or its bytes are not those of a T.
  template <class T>
  bool To(T& sample) const {
    return type == kTypeOf<T> && dds::FromCdr(cdr, sample);
  }
};

/// Returns a count from the recorder's metadata; 0 if it is absent, nothing if it is no valid
/// count: not a number, or so large that adding a few would overflow.
std::optional<std::uint64_t> CountIn(const mcap::StringMap& metadata, const std::string& key);

/// Reads a recording in order: one file, or its splits one after the other.  In samples recorded by
/// an older version, fields added since are zero (idl/session.idl).
class RecordingReader {
 public:
  /// Throws Error if a file cannot be read, or is not an MCAP file.
  explicit RecordingReader(const std::vector<std::string>& files);

  /// Reads the next sample; false at the end.  Samples of unknown types are skipped and counted.
  bool Next(RecordedSample& sample);
  /// Starts again from the beginning.
  void Restart();

  /// The position of the last sample: going there reads its chunk again from the chunk's start.
  /// Valid after Next has returned true.
  struct Place {
    std::size_t file = 0, offset = 0;
    friend bool operator==(const Place&, const Place&) = default;
  };
  Place place() const { return {begun_ - 1, readers_[begun_ - 1]->offset()}; }
  /// Continues from a place returned since the last Restart.  Samples that are read again count
  /// again in unknown().
  void GoTo(const Place& place);
  /// Call it after Next has returned false: takes in what the recorder has appended to the
  /// last file.
  void Grow();

  // These describe what has been read so far, so the whole recording once Next has returned false.
  bool complete() const { return complete_; }  ///< every file so far has its end
  bool damaged() const;                        ///< bytes of some file were altered
  std::vector<std::string> problems() const;
  std::vector<mcap::Metadata> metadata() const;
  std::uint64_t unknown() const { return unknown_; }
  std::uint64_t bytes() const;

 private:
  std::vector<std::string> names_;
  std::vector<std::unique_ptr<mcap::MappedFile>> files_;
  std::vector<std::unique_ptr<mcap::Reader>> readers_;  // of the files opened so far
  std::size_t begun_ = 0;                               // number of files opened since the
                                                        // last restart
  std::vector<std::uint8_t> older_;                     // the last sample, if it had to be extended
  bool complete_ = true;
  std::uint64_t unknown_ = 0;
};

}  // namespace palpate
