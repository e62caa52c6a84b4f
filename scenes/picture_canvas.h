#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/picture_tile.h"

namespace palpate {

/// Tiles, bars and letters, as a PNG.
class Canvas {
 public:
  static constexpr int kLetterWidth = 12,
                       kLetterHeight = 14;  ///< without what hangs below [pixels]

  /// White.
  Canvas(int width, int height);

  /// @param x, y  of the left upper corner, here and below; what lies outside is left out.
  void Place(const Tile& tile, int x, int y);
  void Fill(int x, int y, int width, int height, const Colour& colour);
  /// Letters of ASCII; what has none is a gap.
  void Write(std::string_view text, int x, int y);
  /// The same with its middle at x.
  void WriteCentred(std::string_view text, int x, int y);

  /// Throws Error where the file cannot be written.
  void Save(const std::string& png_file) const;

 private:
  void Set(int x, int y, const Colour& colour);

  int width_, height_;
  std::vector<std::uint8_t> pixels_;
};

}  // namespace palpate
