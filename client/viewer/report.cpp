#include "client/viewer/report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "client/viewer/page_messages.h"
#include "common/metrics/metrics_page.h"
#include "common/realtime/steady_clock.h"
#include "common/text/joined.h"

namespace palpate {
namespace {

constexpr std::int64_t kStatistics_ns = 5'000'000'000;

std::string OrNone(const std::string& text) {
  return text.empty() ? "none" : text;
}

}  // namespace

std::string HealthOf(Viewers& viewers, const TopicFeed& feed, const MouseRoom& mice) {
  const Viewers::Traffic traffic = viewers.traffic();
  nlohmann::json compiling;
  if (const wire::SceneProgress* of = feed.compiling()) {
    compiling = {{"scene", of->scene}, {"stage", of->stage}, {"done", of->done}};
  }
  return ToText(nlohmann::json({{"viewers", viewers.all().size()},
                                {"max_viewers", viewers.places().most()},
                                {"frames_sent", traffic.sent},
                                {"frames_dropped", traffic.lost},
                                {"bytes_sent", traffic.bytes},
                                {"mice", mice.size()},
                                {"refusals", viewers.refusals().count()},
                                {"stations", feed.stations()},
                                {"scenes", NamesOf(feed.scenes())},
                                {"server_run", fmt::format("{:x}", feed.server().run)},
                                {"server_lives", feed.server().lives},
                                {"compiling", compiling},
                                {"version", PALPATE_VERSION}}));
}

std::string MetricsOf(Viewers& viewers, const TopicFeed& feed, const MouseRoom& mice) {
  const Viewers::Traffic traffic = viewers.traffic();
  MetricsPage page;
  page.Add(metric::kGatewayBuild, 1.0, {{"version", PALPATE_VERSION}});
  page.Add(metric::kGatewayMemory, ResidentMemoryBytes());
  page.Add(metric::kGatewayViewers, std::uint64_t{viewers.all().size()});
  page.Add(metric::kGatewayViewersLimit, std::uint64_t{viewers.places().most()});
  page.Add(metric::kGatewayMice, std::uint64_t{mice.size()});
  page.Add(metric::kGatewayStations, std::uint64_t{feed.stations().size()});
  page.Add(metric::kGatewayScenes, std::uint64_t{feed.scenes().size()});
  page.Add(metric::kGatewayIn, traffic.taken);
  page.Add(metric::kGatewayOut, traffic.sent);
  page.Add(metric::kGatewayDropped, traffic.lost);
  page.Add(metric::kGatewayBytes, traffic.bytes);
  page.Add(metric::kGatewayRefusals, viewers.refusals().count());
  return page.ToText();
}

StatisticsLog::StatisticsLog() : logged_ns_(SteadyNanoseconds()) {}

void StatisticsLog::Poll(const Viewers& viewers, const TopicFeed& feed, std::int64_t now_ns) {
  if (now_ns - logged_ns_ < kStatistics_ns) return;
  const double seconds = 1e-9 * static_cast<double>(now_ns - logged_ns_);
  const Viewers::Traffic now = viewers.traffic();
  const auto rate = [&](std::uint64_t Viewers::Traffic::*of) {
    return static_cast<double>(now.*of - logged_.*of) / seconds;
  };
  spdlog::info(
      "viewers {}  frames in {:.0f}/s  out {:.0f}/s  {:.2f} MB/s  lost {} (+{})  stations {}  "
      "scenes {}",
      viewers.all().size(), rate(&Viewers::Traffic::taken), rate(&Viewers::Traffic::sent),
      1e-6 * rate(&Viewers::Traffic::bytes), now.lost, now.lost - logged_.lost,
      OrNone(Joined(feed.stations())), OrNone(Joined(NamesOf(feed.scenes()))));
  logged_ = now;
  logged_ns_ = now_ns;
}

}  // namespace palpate
