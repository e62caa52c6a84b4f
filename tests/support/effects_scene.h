#pragma once

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

}  // namespace palpate::test
