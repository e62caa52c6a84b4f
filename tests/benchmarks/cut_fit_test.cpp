#include <cmath>
#include <fstream>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include "tests/benchmarks/bench_fixture.h"
#include "tests/support/random.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

class CutFit : public PalpateBench {
 protected:
  int Fit(const std::string& rows) {
    std::ofstream(File("feeds.csv")) << "material,area_mm2,share,feed_mm_per_s,force_N\n" << rows;
    return Run({"cut", "--fit", File("feeds.csv"), "--json", File("fit.json")});
  }
};

TEST_F(CutFit, FindsTheLawThatThePointsWereMadeBy) {
  Random random(1);
  std::string rows;
  const double ball = std::numbers::pi * 0.49;
  for (const double feed : {0.2, 0.5, 1.0, 2.0}) {
    rows +=
        fmt::format("enamel,{},0.6666666667,{},{}\n", ball, feed, ball * (0.5 + 0.3 * feed / 1.5));
    rows += fmt::format("bone,4.909,1,{},{}\n", feed,
                        4.909 * (2.0 + 0.7 * feed) + random.Uniform(-0.1, 0.1));
  }
  ASSERT_EQ(Fit(rows), 0) << said_;
  const nlohmann::json laws = Json("fit.json")["laws"];
  ASSERT_EQ(laws.size(), 2u);
  EXPECT_EQ(laws[0]["material"], "enamel");
  EXPECT_NEAR(laws[0]["cutting_pressure_MPa"], 0.5, 1e-4);
  EXPECT_NEAR(laws[0]["cutting_viscosity_MPa_s_per_mm"], 0.3, 1e-4);
  EXPECT_LT(laws[0]["residual_N_rms"], 1e-4);
  EXPECT_NEAR(laws[1]["cutting_pressure_MPa"], 2.0, 0.03);
  EXPECT_NEAR(laws[1]["cutting_viscosity_MPa_s_per_mm"], 0.7, 0.03);
  EXPECT_GT(laws[1]["residual_N_rms"], 1e-3);
  EXPECT_LT(laws[1]["residual_N_rms"], 0.1);
  EXPECT_THAT(said_, HasSubstr("bone: \"cutting_pressure_MPa\": "));
}

TEST_F(CutFit, AForceThatFallsWithTheFeedHasNoViscosity) {
  ASSERT_EQ(Fit("a,1,1,1,3\na,1,1,2,2\n"), 0) << said_;
  const nlohmann::json law = Json("fit.json")["laws"][0];
  EXPECT_EQ(law["cutting_viscosity_MPa_s_per_mm"], 0.0);
  EXPECT_NEAR(law["cutting_pressure_MPa"], 2.5, 1e-9);
  EXPECT_NEAR(law["residual_N_rms"], 0.5, 1e-9);
}

TEST_F(CutFit, TakesTheFirstRowOfAFileWithoutTitlesForAPoint) {
  for (const char* begin : {"", "\xEF\xBB\xBF", "# measured\n", "material,A,s,u,F\n"}) {
    std::ofstream(File("bare.csv")) << begin << "a,1,1,0,1.2\na,1,1,1,1.5\na,1,1,2,1.2\n";
    ASSERT_EQ(Run({"cut", "--fit", File("bare.csv"), "--json", File("bare.json")}), 0) << said_;
    EXPECT_NEAR(Json("bare.json")["laws"][0]["cutting_pressure_MPa"], 1.3, 1e-9) << begin;
  }
}

TEST_F(CutFit, NamesTheRowAndTheRemedy) {
  EXPECT_EQ(Fit("enamel,1.5,1,1,0.9\nenamel,1.5,1,1,1.1\n"), 1);
  EXPECT_THAT(said_, HasSubstr("enamel: has a single feed"));
  EXPECT_EQ(Fit("enamel,1.5,1,1\n"), 1);
  EXPECT_THAT(said_, HasSubstr("feeds.csv:2: needs five columns"));
  EXPECT_EQ(Fit("enamel,1.5,1,one,2\n"), 1);
  EXPECT_THAT(said_, HasSubstr("feeds.csv:2: \"one\" is not a number"));
  EXPECT_EQ(Fit(""), 1);
  EXPECT_THAT(said_, HasSubstr("holds no point"));
}

}  // namespace
}  // namespace palpate::test
