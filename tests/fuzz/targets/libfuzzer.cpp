// A target under libFuzzer, which is guided by coverage: cmake --preset fuzz (clang).  If the first
// word is --seeds FOLDER, writes the target's valid inputs there.
#include <cstring>
#include <filesystem>
#include <fstream>

#include "tests/fuzz/targets/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  palpate::fuzz::PALPATE_FUZZ_TARGET(bytes, size);
  return 0;
}

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  if (*argc < 3 || std::strcmp((*argv)[1], "--seeds") != 0) return 0;
  for (const palpate::fuzz::Target& target : palpate::fuzz::AllTargets()) {
    if (target.run != palpate::fuzz::PALPATE_FUZZ_TARGET) continue;
    int number = 0;
    for (const std::string& seed : target.seeds()) {
      std::ofstream(std::filesystem::path((*argv)[2]) / std::to_string(number++), std::ios::binary)
          << seed;
    }
  }
  std::exit(0);
}
