#include "client/viewer/viewers.h"

#include <random>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

std::string RandomId() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}", random(), random());
}

}  // namespace

Viewers::Viewers(std::size_t most) : session_id_(RandomId()), places_(most) {}

bool Viewers::MakeRoom(const std::string& address) {
  const std::int64_t now_ns = SteadyNanoseconds();
  const ViewerPlaces::Room room = places_.RoomFor(address, now_ns);
  if (room.leaves) {
    // At once: a viewer that reads nothing would delay an orderly close.
    const std::shared_ptr<Viewer> leaves = all_.at(*room.leaves);
    refusals_.Say(Refusal::kFull, leaves->guest().visitor.name,
                  "its place is another address's, which has fewer (--max-viewers)", now_ns);
    leaves->Gone();
  }
  return room.is_there;
}

void Viewers::Join(const std::shared_ptr<Viewer>& viewer) {
  all_[viewer->id()] = viewer;
  places_.Enter(viewer->id(), viewer->guest().visitor.address, SteadyNanoseconds());
}

void Viewers::Leave(const Viewer& viewer) {
  const auto [sent, lost] = viewer.frames();
  traffic_.lost += lost;
  if (lost > 0) {
    spdlog::info("viewer {} has left: {} frames sent, {} lost because it was slow",
                 viewer.guest().visitor.name, sent, lost);
  }
  const std::uint64_t id = viewer.id();
  places_.Leave(id);
  wishes_.Leave(id);
  all_.erase(id);  // a handler may be the last to hold it
}

std::string Viewers::Refuse(Wish wish, Viewer& viewer, std::int64_t now_ns) {
  const Guest& guest = viewer.guest();
  const WishLimits::Verdict verdict = wishes_.Ask(wish, guest.id, guest.visitor.address, now_ns);
  if (verdict.granted) return "";
  const std::string reason = TooOften(wish);
  refusals_.Say(wish == Wish::kTake ? Refusal::kTakes : Refusal::kWishes, guest.Who(), reason,
                now_ns);
  if (verdict.tell) viewer.Say(foxglove::Level::kError, reason);
  return reason;
}

void Viewers::Distribute(const FramePtr& frame, std::int64_t now_ns) {
  ++traffic_.taken;
  for (const auto& [id, viewer] : all_) viewer->Push(frame, now_ns);
}

void Viewers::Tick(std::int64_t now_ns) {
  refusals_.Poll(now_ns);
  const auto viewers = all_;  // Flush may remove one
  for (const auto& [id, viewer] : viewers) {
    viewer->Flush(now_ns);
    viewer->Watch(now_ns);
  }
}

void Viewers::CountSent(std::size_t bytes) {
  ++traffic_.sent;
  traffic_.bytes += bytes;
}

Viewers::Traffic Viewers::traffic() const {
  Traffic all = traffic_;
  for (const auto& [id, viewer] : all_) all.lost += viewer->frames().lost;
  return all;
}

}  // namespace palpate
