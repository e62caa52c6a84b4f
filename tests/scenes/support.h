#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/math/pose.h"
#include "scenes/scene.h"
#include "scenes/shapes/shapes.h"
#include "tests/support/complaint.h"

namespace palpate::test {

/// The same numbers in every run, from a generator that the sources do not use.
class Numbers {
 public:
  double Uniform(double low, double high) {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * static_cast<double>(state_ >> 11) * 0x1p-53;
  }
  Vec3 Point(double half) {
    const double x = Uniform(-half, half);
    const double y = Uniform(-half, half);
    return {x, y, Uniform(-half, half)};
  }

 private:
  std::uint64_t state_ = 1;
};

/// Triangles in no order: open and intersecting.
inline TriangleMesh TriangleSoup(Numbers& numbers, int count, double size) {
  TriangleMesh mesh;
  for (int t = 0; t < count; ++t) {
    const Vec3 at = numbers.Point(1.0);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int c = 0; c < 3; ++c) mesh.vertices.push_back(at + numbers.Point(size));
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

/// An empty folder for the current test.
inline std::string FreshFolder() {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) /
      (std::string("palpate-") + info->test_suite_name() + "-" + info->name());
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder.string();
}

inline std::string WriteFile(const std::string& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
  return file;
}

}  // namespace palpate::test
