#include "scenes/picture_canvas.h"

#include <algorithm>
#include <cmath>

#include <png.h>

#include "common/error.h"

namespace palpate {

Canvas::Canvas(int width, int height)
    : width_(width), height_(height), pixels_(3 * std::size_t(width) * std::size_t(height), 255) {}

void Canvas::Place(const Tile& tile, int x, int y) {
  for (int row = 0; row < Tile::kSide; ++row) {
    for (int column = 0; column < Tile::kSide; ++column) {
      Set(x + column, y + row, tile.At(column, row));
    }
  }
}

void Canvas::Save(const std::string& png_file) const {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width_);
  image.height = static_cast<png_uint_32>(height_);
  image.format = PNG_FORMAT_RGB;
  if (!png_image_write_to_file(&image, png_file.c_str(), 0, pixels_.data(), 0, nullptr)) {
    throw Error(png_file + ": cannot be written (" + image.message + "); check the folder");
  }
}

void Canvas::Set(int x, int y, const Colour& colour) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
  for (int k = 0; k < 3; ++k) {
    pixels_[3 * (std::size_t(y) * width_ + x) + k] =
        static_cast<std::uint8_t>(255.0 * std::sqrt(std::clamp(colour[k], 0.0, 1.0)) + 0.5);
  }
}

}  // namespace palpate
