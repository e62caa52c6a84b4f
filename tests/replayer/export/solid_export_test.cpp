#include "client/replayer/export/solid_export.h"

#include <csignal>
#include <cstring>
#include <map>
#include <numbers>

#include <gmock/gmock.h>

#include "client/replayer/verify/verify.h"
#include "common/error.h"
#include "scenes/grid/solid_grid.h"
#include "tests/replayer/cut_recording.h"
#include "tests/support/complaint.h"
#include "tests/support/read_file.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

/// What any reader finds in a binary STL file: enclosed volume, and edges without a twin.
struct Stl {
  double volume_mm3 = 0.0;
  std::size_t triangles = 0, open_edges = 0;
  Vec3 low = Vec3::Constant(1e9), high = Vec3::Constant(-1e9);
};
Stl ReadStl(const std::string& file) {
  const std::string bytes = ReadWholeFile(file);
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, 4);
  EXPECT_EQ(bytes.size(), 84u + 50u * count);
  Stl stl;
  stl.triangles = count;
  std::map<std::pair<std::string, std::string>, int> edges;
  for (std::uint32_t t = 0; t < count; ++t) {
    std::array<Vec3, 3> p;
    std::array<std::string, 3> raw;
    for (std::size_t c = 0; c < 3; ++c) {
      const char* at = bytes.data() + 84 + 50 * t + 12 + 12 * c;
      raw[c].assign(at, 12);
      float xyz[3];
      std::memcpy(xyz, at, 12);
      p[c] = {xyz[0], xyz[1], xyz[2]};
      stl.low = stl.low.cwiseMin(p[c]);
      stl.high = stl.high.cwiseMax(p[c]);
    }
    stl.volume_mm3 += p[0].dot(p[1].cross(p[2])) / 6.0;
    for (std::size_t c = 0; c < 3; ++c) {
      ++edges[{raw[c], raw[(c + 1) % 3]}];
      --edges[{raw[(c + 1) % 3], raw[c]}];
    }
  }
  for (const auto& [edge, sum] : edges) stl.open_edges += sum != 0;
  return stl;
}

class SolidExport : public testing::Test {
 protected:
  void Run(double at_s = std::numeric_limits<double>::infinity()) {
    std::error_code ignored;
    std::filesystem::remove_all(out, ignored);
    ExportSolids({.files = {recording}, .folder = out, .at_s = at_s}, stop);
  }
  Folder folder;
  std::string recording = folder / "day.mcap", out = folder / "out";
  StopSignal stop;
};

TEST_F(SolidExport, IsClosedAndHasTheVolumeThatIsGraded) {
  RecordCut(recording, 250, Down(1.2));
  const Verification verified = Verify({recording}, {.whose = {{"hand", 9}}});
  double left = 0.0;
  for (const double m3 : verified.sessions[0].cut->after[0].VolumeLeft()) left += 1e9 * m3;
  // Half a ball and a cylinder above it, less the bur's lag behind the hand.
  EXPECT_NEAR(27.0 - left, std::numbers::pi * (0.25 * 0.7 + 0.25 / 3.0), 0.05);

  Run();
  const Stl stl = ReadStl(out + "/block.stl");
  EXPECT_EQ(stl.open_edges, 0u);
  EXPECT_GT(stl.triangles, 1000u);
  EXPECT_NEAR(stl.volume_mm3, left, 0.003 * 27.0);
  EXPECT_NEAR(stl.high.x(), 1.5, 0.01) << "in the solid's own frame, in mm";

  const std::string ply = ReadWholeFile(out + "/block.ply");
  EXPECT_THAT(ply.substr(0, 500),
              testing::AllOf(HasSubstr("format binary_little_endian 1.0"),
                             HasSubstr("element face " + std::to_string(stl.triangles))));
  // A face: count, three corners, and a colour: enamel's, or that of a material without one.
  const char* faces = ply.data() + ply.size() - 16 * stl.triangles;
  std::map<std::string, std::size_t> colours;
  for (std::size_t t = 0; t < stl.triangles; ++t) {
    ASSERT_EQ(faces[16 * t], 3);
    ++colours[std::string(faces + 16 * t + 13, 3)];
  }
  EXPECT_EQ(colours.size(), 2u);
  EXPECT_GT(colours[std::string("\xff\0\0", 3)], 500u);
}

TEST_F(SolidExport, LoadsAgainAsASceneThatIsCutOnFromThere) {
  RecordCut(recording, 250, Down(1.2));
  Run();
  const Scene scene = LoadScene(out + "/block.palpate");
  const auto objects = MakeObjects(scene);
  ASSERT_EQ(objects->solids.size(), 1u);
  const SolidGrid& grid = *objects->solids[0].grid;
  EXPECT_GT(grid.Sample(Vec3(0, 0.6e-3, 0)).distance, 50e-6) << "the cavity";
  EXPECT_LT(grid.Sample(Vec3(0, 0.1e-3, 0)).distance, -50e-6) << "below its floor";
  EXPECT_EQ(grid.Material(Vec3(1e-3, 0.5e-3, 0)), 1);
  EXPECT_EQ(grid.Material(Vec3(1e-3, 0.6e-3, 0)), 0);
  const CutField field(grid, kMostGridBytes, "block");
  double left = 0.0;
  for (const double m3 : field.VolumeLeft()) left += 1e9 * m3;
  EXPECT_NEAR(left, ReadStl(out + "/block.stl").volume_mm3, 0.003 * 27.0);
  EXPECT_NE(MakeModel(scene, scene.tools[0], objects).cutting(), nullptr);
}

TEST_F(SolidExport, TellsWhatWasThereAtATime) {
  RecordCut(recording, 250, Down(1.2));
  Run(0.04);  // still above the block
  EXPECT_NEAR(ReadStl(out + "/block.stl").volume_mm3, 27.0, 0.1);
  Run(0.12);  // 0.7 mm deep
  const double half = 27.0 - ReadStl(out + "/block.stl").volume_mm3;
  Run();
  const double all = 27.0 - ReadStl(out + "/block.stl").volume_mm3;
  EXPECT_GT(half, 0.4 * all);
  EXPECT_LT(half, 0.8 * all);
}

TEST_F(SolidExport, SaysWhatIsWrongAndLeavesNothing) {
  RecordCut(recording, 60, Down(1.2));
  const auto complaint = [&](double at_s) { return ComplaintOf([&] { Run(at_s); }); };
  EXPECT_THAT(complaint(0.0), HasSubstr("no hand with a bur has come by 0 s; give a later --at"));
  std::ofstream(folder / "file") << "mine";
  out = folder / "file/out";
  EXPECT_THAT(complaint(1.0), HasSubstr("cannot be made"));
  out = folder / "stopped";
  std::raise(SIGINT);
  EXPECT_THAT(complaint(1.0), HasSubstr("stopped before"));
  EXPECT_FALSE(std::filesystem::exists(out));
  EXPECT_FALSE(std::filesystem::exists(out + ".part"));
}

}  // namespace
}  // namespace palpate::test
