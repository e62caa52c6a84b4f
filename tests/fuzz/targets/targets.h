#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace palpate::fuzz {

/// What anybody may give to a program, as bytes.  Each takes any bytes whatever and comes back:
/// where they are nothing, by an Error of ours.  Anything else is a fault: it aborts.  Whether they
/// were taken.
bool SceneFile(const std::uint8_t* bytes, std::size_t size);  ///< JSON that people write
bool Script(const std::uint8_t* bytes, std::size_t size);     ///< a hand's path, JSON too
bool Sph(const std::uint8_t* bytes, std::size_t size);        ///< sphere trees of the toolkit
bool MeshFile(const std::uint8_t* bytes, std::size_t size);   ///< of the format by its first byte
bool Bundle(const std::uint8_t* bytes, std::size_t size);     ///< a scene at rest, but its header
bool Recording(const std::uint8_t* bytes, std::size_t size);  ///< MCAP
bool Client(const std::uint8_t* bytes, std::size_t size);  ///< a viewer's messages, text and binary
bool Wire(const std::uint8_t* bytes, std::size_t size);    ///< CDR of each type that travels
bool Qp(const std::uint8_t* bytes, std::size_t size);  ///< rows and a target; the answer is judged

struct Target {
  const char* name;
  bool (*run)(const std::uint8_t*, std::size_t);
  /// Whole inputs to begin with.
  std::vector<std::string> (*seeds)();
};
const std::vector<Target>& AllTargets();

}  // namespace palpate::fuzz
