#include "server/library/parameters.h"

#include <cmath>
#include <limits>
#include <regex>
#include <sstream>
#include <string>

#include <gmock/gmock.h>

#include "scenes/shapes/shapes.h"
#include "server/library/body_builder.h"
#include "server/physics/scene_model.h"
#include "tests/support/complaint.h"
#include "tests/support/read_file.h"

namespace palpate::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

Scene BallOnBlock() {
  Scene scene;
  scene.objects.push_back(MakeBody("block", MakeBox({0.04, 0.04, 0.04}), {.leaves = 64}));
  scene.tools.push_back(MakeBall("ball", 0.005));
  return scene;
}

double ValueOf(const Scene& scene, std::string_view name) {
  for (const Parameter& parameter : ParametersOf(scene)) {
    if (name == parameter.name) return parameter.value;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

TEST(Parameters, TakeBothEndsOfTheirRangesAndNothingBeyond) {
  Scene scene = BallOnBlock();
  for (const Parameter& parameter : ParametersOf(scene)) {
    EXPECT_EQ(parameter.value, parameter.usual) << parameter.name;
    for (const double value : {parameter.least, parameter.most}) {
      SetParameter(scene, parameter.name, value);
      EXPECT_DOUBLE_EQ(ValueOf(scene, parameter.name), value) << parameter.name;
    }
    for (const double value : {parameter.least - 0.5, 2.0 * parameter.most, std::nan("")}) {
      EXPECT_THAT(ComplaintOf([&] { SetParameter(scene, parameter.name, value); }),
                  AllOf(HasSubstr(parameter.name), HasSubstr("from")));
      EXPECT_DOUBLE_EQ(ValueOf(scene, parameter.name), parameter.most) << "nothing is changed";
    }
  }
  EXPECT_EQ(TuningFault(scene.tuning), "");
  EXPECT_THAT(ComplaintOf([&] { SetParameter(scene, "sub_steps", 2.5); }),
              HasSubstr("a whole number from 1 to 64"));
  EXPECT_THAT(ComplaintOf([&] { SetParameter(scene, "seperation_um", 2.0); }),
              AllOf(HasSubstr("seperation_um is not known"), HasSubstr("mean \"separation_um")));
}

TEST(Parameters, AreRefusedByTheModelToo) {
  Scene scene = BallOnBlock();
  const auto make = [&] { MakeModel(scene, scene.tools[0], MakeObjects(scene)); };
  scene.coupling.stiffness = 1e9;
  EXPECT_THAT(ComplaintOf(make), HasSubstr("stiffness_N_per_m is 1e+09"));
  scene.coupling = {1000.0, 0.0};
  EXPECT_THAT(ComplaintOf(make), HasSubstr("torsional_stiffness_Nm_per_rad is 0"));
  scene.coupling = {};
  scene.objects[0].materials[0].static_friction = 11.0;
  EXPECT_THAT(ComplaintOf(make), HasSubstr("friction: is 11"));
  scene.objects[0].materials[0].static_friction = std::nan("");
  EXPECT_THAT(ComplaintOf(make), HasSubstr("friction: "));
}

TEST(Parameters, ReachTheStep) {
  Scene scene = BallOnBlock();
  SetParameter(scene, "stiffness_N_per_m", 500.0);
  SetParameter(scene, "separation_um", 2.0);
  SetParameter(scene, "friction", 0.4);
  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
  EXPECT_EQ(model.parameters().stiffness, 500.0);
  EXPECT_EQ(model.parameters().separation, 2e-6);
  EXPECT_EQ(model.parameters().features.friction, FrictionModel::kCoulomb);
  EXPECT_EQ(scene.objects[0].materials[0].dynamic_friction, 0.4);
  scene.objects[0].materials[0].static_friction = 0.6;
  EXPECT_TRUE(std::isnan(ValueOf(scene, "friction"))) << "no one number";
}

TEST(Parameters, StandOnThePageOfThePhysics) {
  std::string page = ReadWholeFile(PALPATE_SOURCE_DIR "/server/physics/README.md");
  page = std::regex_replace(page, std::regex(",(\\d{3})"), "$1");
  for (const Parameter& parameter : ParametersOf(Scene{})) {
    std::ostringstream row;
    row << "| `\"" << parameter.name << "\"` | " << parameter.usual << ", " << parameter.least
        << " to " << parameter.most << " |";
    EXPECT_THAT(page, HasSubstr(row.str()));
  }
}

}  // namespace
}  // namespace palpate::test
