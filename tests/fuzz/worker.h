#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace palpate::test {

/// Where a try is.  In somebody else's code it may die, as palpate-import does in its user's place;
/// in ours nothing may.
enum class Code : std::int32_t { kOurs, kTheirs };

/// What came of a number of tries.
struct Tries {
  std::size_t done = 0;
  std::size_t accepted = 0;
  std::size_t deaths_in_theirs = 0;
  std::size_t peak_bytes = 0;       ///< of the largest worker, resident
  std::vector<std::string> faults;  ///< "try 17: died of Segmentation fault": of ours
};

/// Runs tries 0 to `count` in workers that may die: each has a gigabyte of address space (without
/// the sanitizers) and each try ten seconds of processor time.
/// @param run  makes its input of the try's number; says by Enter whose code it is in.  Returns
///             whether the input was accepted; a text that is not empty is a fault.
class Worker {
 public:
  using Run = std::function<bool(std::size_t number, std::string& fault)>;
  /// Outside a worker it says nothing.
  static void Enter(Code code);
  static Tries RunAll(std::size_t count, const Run& run);
};

/// How many tries: PALPATE_FUZZ_TRIES where it is set, for a long run by hand; else `briefly`.
std::size_t TriesOr(std::size_t briefly);

}  // namespace palpate::test
