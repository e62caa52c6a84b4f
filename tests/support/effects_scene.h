#pragma once

#include <cstdlib>
#include <fstream>
#include <string>
#include <string_view>

namespace palpate::test {

/// Returns the text of the catalogue's cube with effects, without leaves, so that it loads at once.
inline std::string CubeWithEffects(const std::string& effects) {
  std::string text;
  std::getline(std::ifstream(PALPATE_SOURCE_DIR "/scenes/catalogue/cube.json"), text, '\0');
  constexpr std::string_view kLeaves = ",\n      \"leaves\": 4096";
  text.erase(text.find(kLeaves), kLeaves.size());
  return text.insert(1, "\n\"effects\": [" + effects + "],");
}

/// Trusts the effects in these folders, separated by :, as --effects does, while it lives.
struct TrustedEffects {
  explicit TrustedEffects(const std::string& folders) {
    if (const char* former = std::getenv("PALPATE_EFFECTS")) former_ = former;
    setenv("PALPATE_EFFECTS", folders.c_str(), 1);
  }
  ~TrustedEffects() { setenv("PALPATE_EFFECTS", former_.c_str(), 1); }
  TrustedEffects(const TrustedEffects&) = delete;
  TrustedEffects& operator=(const TrustedEffects&) = delete;

 private:
  std::string former_;
};

}  // namespace palpate::test
