#include "scenes/picture_canvas.h"

#include <algorithm>
#include <cmath>

#include <png.h>

#include "common/error.h"

namespace palpate {
namespace {

// Letters of 5 x 7 dots, and two rows for descenders; a dot is two pixels wide.  Five bits per row,
// top row first.
constexpr std::string_view kLetters =
    "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ-abcdefghijklmnopqrstuvwxyz.,:+%()/=_";
constexpr std::uint8_t kDots[][9] = {{14, 17, 19, 21, 25, 17, 14},
                                     {4, 12, 4, 4, 4, 4, 14},
                                     {14, 17, 1, 2, 4, 8, 31},
                                     {31, 2, 4, 2, 1, 17, 14},
                                     {2, 6, 10, 18, 31, 2, 2},
                                     {31, 16, 30, 1, 1, 17, 14},
                                     {6, 8, 16, 30, 17, 17, 14},
                                     {31, 1, 2, 4, 8, 8, 8},
                                     {14, 17, 17, 14, 17, 17, 14},
                                     {14, 17, 17, 15, 1, 2, 12},
                                     {14, 17, 17, 31, 17, 17, 17},
                                     {30, 17, 17, 30, 17, 17, 30},
                                     {14, 17, 16, 16, 16, 17, 14},
                                     {28, 18, 17, 17, 17, 18, 28},
                                     {31, 16, 16, 30, 16, 16, 31},
                                     {31, 16, 16, 30, 16, 16, 16},
                                     {14, 17, 16, 23, 17, 17, 15},
                                     {17, 17, 17, 31, 17, 17, 17},
                                     {14, 4, 4, 4, 4, 4, 14},
                                     {7, 2, 2, 2, 2, 18, 12},
                                     {17, 18, 20, 24, 20, 18, 17},
                                     {16, 16, 16, 16, 16, 16, 31},
                                     {17, 27, 21, 21, 17, 17, 17},
                                     {17, 17, 25, 21, 19, 17, 17},
                                     {14, 17, 17, 17, 17, 17, 14},
                                     {30, 17, 17, 30, 16, 16, 16},
                                     {14, 17, 17, 17, 21, 18, 13},
                                     {30, 17, 17, 30, 20, 18, 17},
                                     {15, 16, 16, 14, 1, 1, 30},
                                     {31, 4, 4, 4, 4, 4, 4},
                                     {17, 17, 17, 17, 17, 17, 14},
                                     {17, 17, 17, 17, 17, 10, 4},
                                     {17, 17, 17, 21, 21, 21, 10},
                                     {17, 17, 10, 4, 10, 17, 17},
                                     {17, 17, 17, 10, 4, 4, 4},
                                     {31, 1, 2, 4, 8, 16, 31},
                                     {0, 0, 0, 31, 0, 0, 0},
                                     {0, 0, 14, 1, 15, 17, 15},
                                     {16, 16, 22, 25, 17, 17, 30},
                                     {0, 0, 14, 16, 16, 17, 14},
                                     {1, 1, 13, 19, 17, 17, 15},
                                     {0, 0, 14, 17, 31, 16, 14},
                                     {6, 9, 8, 28, 8, 8, 8},
                                     {0, 0, 15, 17, 17, 17, 15, 1, 14},
                                     {16, 16, 22, 25, 17, 17, 17},
                                     {4, 0, 12, 4, 4, 4, 14},
                                     {2, 0, 6, 2, 2, 2, 2, 18, 12},
                                     {16, 16, 18, 20, 24, 20, 18},
                                     {12, 4, 4, 4, 4, 4, 14},
                                     {0, 0, 26, 21, 21, 17, 17},
                                     {0, 0, 22, 25, 17, 17, 17},
                                     {0, 0, 14, 17, 17, 17, 14},
                                     {0, 0, 30, 17, 17, 17, 30, 16, 16},
                                     {0, 0, 15, 17, 17, 17, 15, 1, 1},
                                     {0, 0, 22, 25, 16, 16, 16},
                                     {0, 0, 14, 16, 14, 1, 30},
                                     {8, 8, 28, 8, 8, 9, 6},
                                     {0, 0, 17, 17, 17, 19, 13},
                                     {0, 0, 17, 17, 17, 10, 4},
                                     {0, 0, 17, 17, 21, 21, 10},
                                     {0, 0, 17, 10, 4, 10, 17},
                                     {0, 0, 17, 17, 17, 17, 15, 1, 14},
                                     {0, 0, 31, 2, 4, 8, 31},
                                     {0, 0, 0, 0, 0, 12, 12},
                                     {0, 0, 0, 0, 0, 12, 12, 4, 8},
                                     {0, 12, 12, 0, 12, 12, 0},
                                     {0, 4, 4, 31, 4, 4, 0},
                                     {24, 25, 2, 4, 8, 19, 3},
                                     {2, 4, 8, 8, 8, 4, 2},
                                     {8, 4, 2, 2, 2, 4, 8},
                                     {0, 1, 2, 4, 8, 16, 0},
                                     {0, 0, 31, 0, 31, 0, 0},
                                     {0, 0, 0, 0, 0, 0, 31}};
static_assert(std::size(kDots) == kLetters.size());

}  // namespace

Canvas::Canvas(int width, int height)
    : width_(width), height_(height), pixels_(3 * std::size_t(width) * std::size_t(height), 255) {}

void Canvas::Place(const Tile& tile, int x, int y) {
  for (int row = 0; row < Tile::kSide; ++row) {
    for (int column = 0; column < Tile::kSide; ++column) {
      Set(x + column, y + row, tile.At(column, row));
    }
  }
}

void Canvas::Write(std::string_view text, int x, int y) {
  for (const char c : text) {
    const std::size_t letter = kLetters.find(c);
    for (int dot = 0; letter != kLetters.npos && dot < 45 * 4; ++dot) {
      const int column = dot % 10;
      const int row = dot / 10;
      if (kDots[letter][row / 2] >> (4 - column / 2) & 1) {
        Set(x + column, y + row, Colour(0.05, 0.07, 0.1));
      }
    }
    x += kLetterWidth;
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
