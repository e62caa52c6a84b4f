#include "client/viewer/hub.h"

#include <filesystem>
#include <utility>

#include "common/files/project_files.h"
#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

/// palpate-station is installed beside this program.
std::string StationProgram() {
  return (std::filesystem::path(ProgramFolder()) / "palpate-station").string();
}

}  // namespace

Hub::Hub(boost::asio::io_context& io, const ViewerOptions& options)
    : options_(options),
      viewers_(options.max_viewers),
      rights_(options_, viewers_,
              [this](std::uint64_t viewer, const std::string& reason) {
                mice_.Release(viewer, reason, SteadyNanoseconds());
              }),
      feed_(options.domain, options.network),
      mice_(MouseOptions(), [this](const MouseRoom::News& news) { tools_.Hear(news); }),
      course_(rights_.class_room()
                  ? std::make_unique<CourseDesk>(io, options_, viewers_, feed_, mice_, rights_)
                  : nullptr),
      tools_(viewers_, feed_, mice_, course_.get()),
      server_(viewers_, feed_) {}

MouseRoom::Options Hub::MouseOptions() {
  return {options_.max_mice, options_.domain, options_.transport, options_.network,
          StationProgram(),
          // A random prefix: another gateway in the domain has mice of its own.
          "mouse_" + viewers_.session_id().substr(0, 4) + "_", options_.mouse_prefix(),
          [this](const std::string& station, const std::string& who) {
            const auto& tokens = rights_.gate().tokens();
            return feed_.HasStation(station) ||
                   (tokens && tokens->NamesAnother(station, options_.mouse_prefix(), who));
          },
          [this](MouseRoom::Holder holder) {
            const auto viewer = viewers_.all().find(holder);
            const bool has_name = viewer != viewers_.all().end() && viewer->second->guest().holder;
            return has_name ? viewer->second->guest().holder->name : "";
          }};
}

void Hub::Join(const std::shared_ptr<Viewer>& viewer) {
  viewers_.Join(viewer);
  if (course_) course_->Enter(*viewer);
}

void Hub::Leave(const Viewer& viewer) {
  const std::uint64_t id = viewer.id();
  viewers_.Leave(viewer);
  if (course_) course_->NoteChange();
  tools_.Miss(id, "its page has gone", SteadyNanoseconds());
}

bool Hub::Tick(std::int64_t now_ns) {
  feed_.Poll([&](const FramePtr& frame) { viewers_.Distribute(frame, now_ns); },
             [&](const wire::SessionState& state) { mice_.OnSession(state, now_ns); },
             [&](const wire::SceneWhole& whole, bool is_own) { tools_.Hear(whole, is_own); });
  mice_.Poll(now_ns);
  if (course_) course_->Tick(now_ns);
  viewers_.Tick(now_ns);
  statistics_.Poll(viewers_, feed_, now_ns);
  return !viewers_.all().empty() || mice_.size() > 0 ||
         (course_ && course_->trials().now().size() > 0);
}

void Hub::ReadTokensAnew() {
  if (rights_.ReadAnew() && course_) course_->NoteChange();
}

void Hub::BeginToEnd(std::int64_t now_ns) {
  const auto viewers = viewers_.all();
  for (const auto& [id, viewer] : viewers) {
    if (course_) course_->trials().End(id, "the gateway ends");
    viewer->Close(boost::beast::websocket::close_code::going_away, "the gateway ends");
  }
  mice_.Release(0, "the gateway ends", now_ns);
}

}  // namespace palpate
