#include "tests/station/fake_server.h"

#include <algorithm>
#include <chrono>
#include <random>

#include "common/dds/topics.h"

namespace palpate::test {

FakeServer::FakeServer(int domain, const dds::TransportChoice& transport)
    : loop_(dds::Participant::Loop(domain, transport)),
      service_(dds::Participant::Service(domain)),
      states_(service_, dds::kSessionStateTopic, dds::Qos::kSession),
      requests_(service_, dds::kSessionRequestTopic, dds::Qos::kRecordSession),
      server_run_(std::random_device{}() + 1u),
      thread_([this] { Run(); }) {}

FakeServer::~FakeServer() {
  stop_.store(true);
  thread_.join();
}

void FakeServer::Refuse(const std::string& reason) {
  refusal_ = reason;
  refusing_.store(true);
}

void FakeServer::Publish(wire::SessionPhase phase, const std::string& reason) {
  wire::SessionState state{};
  wire::FromText(request_.station, state.station);
  state.run = request_.run;
  state.server_run = server_run_;
  state.phase = phase;
  wire::FromText(request_.scene, state.scene);
  wire::FromText("sphere", state.tool);
  wire::FromText(reason, state.reason);
  state.muted = muted_;
  state.listeners = static_cast<std::uint32_t>(listeners_);
  states_.Write(state);
}

void FakeServer::OnRequest(const wire::SessionRequest& request) {
  request_ = request;
  if (request.leave) {
    left = true;
    has_session_ = false;
    return Publish(palpate_SESSION_ENDED, "the station left");
  }
  if (held_ = holds.load(); held_) return Publish(palpate_SESSION_HELD, "waits to be admitted");
  if (refusing_.load()) return Publish(palpate_SESSION_REFUSED, refusal_);
  pose_reader_ = {};
  wrenches_ = {loop_, dds::WrenchTopic(request.station, request.run), dds::Qos::kLoop};
  has_session_ = true;
  Publish(palpate_SESSION_WAITING, "");
}

void FakeServer::OnPose(const wire::HapticPose& pose) noexcept {
  if (last_sequence != 0 && pose.pose_sequence != last_sequence + 1) ++gaps;
  last_sequence = pose.pose_sequence;
  ++poses;
  if (mute) return;
  wire::Wrench wrench{};
  wrench.pose_sequence = pose.pose_sequence;
  wrench.pose_time_ns = pose.sample_time_ns - (lies ? 1 : 0);
  wrench.force_N[2] = 1000.0 * std::max(0.0, -pose.position_m[2]);
  wrench.contacts = wrench.force_N[2] > 0.0 ? 1 : 0;
  wrench.step_time_s = 2e-6;
  wrenches_.Write(wrench);
}

void FakeServer::Run() {
  while (!stop_.load()) {
    wire::SessionRequest request;
    while (requests_.Take(request)) OnRequest(request);
    if (has_session_ && !pose_reader_ &&
        dds::WriterDiscovered(loop_, dds::PoseTopic(request_.station, request_.run))) {
      pose_reader_ = {loop_, dds::PoseTopic(request_.station, request_.run), dds::Qos::kLoop,
                      [this](const wire::HapticPose& pose) noexcept { OnPose(pose); }};
      ++sessions;
      Publish(palpate_SESSION_ACTIVE, "");
    }
    if (held_ && !holds.load()) OnRequest(request_);
    if (has_session_ && muted_ != mutes_station) {
      muted_ = mutes_station;
      Publish(palpate_SESSION_ACTIVE, "");
    }
    if (has_session_ && wrenches_.matched_readers() != listeners_) {
      listeners_ = wrenches_.matched_readers();
      Publish(palpate_SESSION_ACTIVE, "");
    }
    const bool says_so = ends_session.exchange(false);
    if (forgets_session.exchange(false) || says_so) {
      has_session_ = false;
      pose_reader_ = {};
      wrenches_ = {};
      if (says_so) Publish(palpate_SESSION_ENDED, "no pose came for more than 100 ms");
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

}  // namespace palpate::test
