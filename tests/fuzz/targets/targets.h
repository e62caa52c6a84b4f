#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace palpate::fuzz {

/// Inputs that anybody may give to a program, as bytes.  Each function takes any bytes and returns
/// whether they were accepted; it refuses them by an Error of ours.  Anything else is a fault, and
/// aborts.
bool SceneFile(const std::uint8_t* bytes, std::size_t size);  ///< JSON that people write
bool Script(const std::uint8_t* bytes, std::size_t size);     ///< a hand's path, JSON too
bool MeshFile(const std::uint8_t* bytes, std::size_t size);   ///< the first byte names the format
bool Bundle(const std::uint8_t* bytes, std::size_t size);     ///< a stored scene without its header
bool Recording(const std::uint8_t* bytes, std::size_t size);  ///< MCAP
bool Client(const std::uint8_t* bytes, std::size_t size);  ///< a viewer's messages, text and binary
bool Wire(const std::uint8_t* bytes, std::size_t size);    ///< CDR of every wire type
bool Qp(const std::uint8_t* bytes, std::size_t size);  ///< rows and a target; the answer is checked

struct Target {
  const char* name;
  bool (*run)(const std::uint8_t*, std::size_t);
  /// Valid inputs to begin with.
  std::vector<std::string> (*seeds)();
};
const std::vector<Target>& AllTargets();

}  // namespace palpate::fuzz
