#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <string>

#include "tests/support/random.h"

namespace palpate::test {

/// One to four changes that a disk, a transfer or a foe makes: a bit, a byte, a number of four
/// bytes or in digits, a piece that is gone, twice there, or all that follows it gone.
inline std::string Spoilt(std::string bytes, Random& random) {
  static constexpr std::uint32_t kNumbers[] = {0,          1,          3,          0xff,
                                               0x7fff,     0xffff,     0x10000,    0x7fffffff,
                                               0x80000000, 0xffffffff, 0x7f800000, 0x7fc00000};
  static constexpr const char* kWords[] = {"-1",    "0",     "4294967295", "99999999999999999999",
                                           "1e300", "1e999", "-1e-320",    "nan",
                                           "\n",    " ",     "null",       "true",
                                           "\"\"",  "[]",    "{}",         "[[[[[["};
  const auto below = [&](std::size_t n) {
    return static_cast<std::size_t>(random.Below(static_cast<int>(n)));
  };
  for (std::size_t changes = 1 + below(4); changes > 0 && !bytes.empty(); --changes) {
    const std::size_t i = below(bytes.size());
    const std::size_t n = std::min(bytes.size() - i, 1 + below(64));
    switch (below(9)) {
      case 0:
        bytes[i] = static_cast<char>(bytes[i] ^ (1 << below(8)));
        break;
      case 1:
        bytes[i] = static_cast<char>(below(256));
        break;
      case 2:
      case 3: {
        const std::uint32_t number = kNumbers[below(std::size(kNumbers))];
        std::memcpy(bytes.data() + i, &number, std::min(sizeof number, bytes.size() - i));
        break;
      }
      case 4:
        bytes.erase(i, n);
        break;
      case 5:
        bytes.insert(below(bytes.size()), bytes.substr(i, n));
        break;
      case 6:
        if (below(4) == 0) bytes.resize(i);
        break;
      default: {
        const std::size_t digit = bytes.find_first_of("0123456789", i);
        if (digit == std::string::npos) break;
        const std::size_t end = bytes.find_first_not_of("0123456789.-", digit);
        const std::string word = below(2) == 0 ? std::to_string(below(300))
                                               : std::string(kWords[below(std::size(kWords))]);
        bytes.replace(digit, std::min(end, bytes.size()) - digit, word);
      }
    }
  }
  return bytes;
}

}  // namespace palpate::test
