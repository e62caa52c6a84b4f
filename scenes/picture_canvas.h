#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "scenes/picture_tile.h"

namespace palpate {

/// A picture of tiles that is saved as a PNG.
class Canvas {
 public:
  /// Begins with a white picture.
  Canvas(int width, int height);

  /// @param x, y  the upper left corner, here and below; what lies outside the picture is cut off.
  void Place(const Tile& tile, int x, int y);
  /// Throws Error if the file cannot be written.
  void Save(const std::string& png_file) const;

 private:
  void Set(int x, int y, const Colour& colour);

  int width_, height_;
  std::vector<std::uint8_t> pixels_;
};

}  // namespace palpate
