#include "common/metrics/metrics_page.h"

#include <gmock/gmock.h>

namespace palpate {
namespace {

using testing::HasSubstr;

TEST(MetricsPage, WritesPrometheussText) {
  MetricsPage page;
  page.Add(metric::kServerLate, std::uint64_t{3}, {{"station", "left"}, {"scene", "cube"}});
  page.Add(metric::kServerMemory, 1.5e6);
  page.Add(metric::kServerLate, std::uint64_t{4}, {{"station", "right"}, {"scene", "cube"}});
  const std::string text = page.ToText();
  EXPECT_THAT(text,
              HasSubstr("# TYPE palpate_server_late_poses_total counter\n"
                        "palpate_server_late_poses_total{station=\"left\",scene=\"cube\"} 3\n"
                        "palpate_server_late_poses_total{station=\"right\",scene=\"cube\"} 4\n"));
  EXPECT_THAT(text, HasSubstr("# TYPE palpate_server_resident_memory_bytes gauge\n"
                              "palpate_server_resident_memory_bytes 1500000\n"));
}

TEST(MetricsPage, LetsNoNameMakeALineOfItsOwn) {
  MetricsPage page;
  page.Add(metric::kServerLate, std::uint64_t{1}, {{"station", "a\"} 7\npalpate_x 9\xff"}});
  const std::string text = page.ToText();
  EXPECT_THAT(text, testing::Not(HasSubstr("\npalpate_x")));
  EXPECT_THAT(text, testing::Not(HasSubstr("\xff")));
}

TEST(MetricsPage, KnowsTheMemoryOfThisProcess) {
  EXPECT_GT(ResidentMemoryBytes(), 1'000'000u);
}

}  // namespace
}  // namespace palpate
