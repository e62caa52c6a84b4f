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

/// A sample as a recording holds it; until the reader's next one.
struct RecordedSample {
  RecordedType type;
  const std::string* topic;
  std::int64_t log_time_ns;
  std::span<const std::uint8_t> cdr;

  /// False where it is of another type, or its bytes are not a T's.
  template <class T>
  bool To(T& sample) const {
    return type == kTypeOf<T> && dds::FromCdr(cdr, sample);
  }
};

/// A count that its recorder says in metadata; 0 where it says none, nothing where it says what no
/// count can be: not a number, or one of which a few more would overflow.
std::optional<std::uint64_t> CountIn(const mcap::StringMap& metadata, const std::string& key);

/// Reads a recording in order: a file, or its splits one after the other.  Samples that an older
/// version recorded have zeros where a type has got fields since (idl/session.idl).
class RecordingReader {
 public:
  /// Throws Error where a file cannot be read, or is no MCAP file.
  explicit RecordingReader(const std::vector<std::string>& files);

  /// Samples of types that this version does not know are passed over, and counted.
  bool Next(RecordedSample& sample);
  /// Begins anew.
  void Restart();

  /// Where to go to for the last sample, with those before it in its chunk.  To be asked for after
  /// a Next that was true.
  struct Place {
    std::size_t file = 0, offset = 0;
    friend bool operator==(const Place&, const Place&) = default;
  };
  Place place() const { return {begun_ - 1, readers_[begun_ - 1]->offset()}; }
  /// Goes on from a place that it has given since it last began anew.  What is read again counts
  /// again in unknown().
  void GoTo(const Place& place);
  /// After Next has returned false: what its recorder has written to the last file since.
  void Grow();

  // Of what has been read; so, of all of it once Next has returned false.
  bool complete() const { return complete_; }  ///< every file has its end
  bool damaged() const;                        ///< bytes of some have changed
  std::vector<std::string> problems() const;
  std::vector<mcap::Metadata> metadata() const;
  std::uint64_t unknown() const { return unknown_; }
  std::uint64_t bytes() const;

 private:
  std::vector<std::string> names_;
  std::vector<std::unique_ptr<mcap::MappedFile>> files_;
  std::vector<std::unique_ptr<mcap::Reader>> readers_;  // of those that were ever begun
  std::size_t begun_ = 0;                               // of them, on the present way
  std::vector<std::uint8_t> older_;  // the last sample, where it needs more bytes
  bool complete_ = true;
  std::uint64_t unknown_ = 0;
};

}  // namespace palpate
