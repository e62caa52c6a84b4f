#include "server/transport/station_link.h"

#include <utility>

#include "common/dds/topics.h"
#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

constexpr std::int64_t kTimeToMatch_ns = 50'000'000;

}  // namespace

StationLink::StationLink(const dds::Participant& loop_domain, std::shared_ptr<Session> session)
    : loop_domain_(loop_domain),
      session_(std::move(session)),
      pose_topic_(dds::PoseTopic(session_->station(), session_->run())),
      wrench_writer_(loop_domain, dds::WrenchTopic(session_->station(), session_->run()),
                     dds::Qos::kLoop) {
  if (session_->below_arms()) {
    background_.emplace([this](const wire::HapticPose& pose) { Answer(pose); });
  }
}

void StationLink::Update(std::int64_t now_ns, bool alone) {
  alone_.store(alone, std::memory_order_relaxed);
  if (!pose_reader_ && dds::WriterDiscovered(loop_domain_, pose_topic_)) {
    pose_reader_ =
        dds::Reader<wire::HapticPose>(loop_domain_, pose_topic_, dds::Qos::kLoop,
                                      [this](const wire::HapticPose& pose) { OnPose(pose); });
  }
  const int readers = wrench_writer_.matched_readers();
  if (open_.load(std::memory_order_relaxed)) return session_->TellListeners(readers);
  if (readers == 0) {
    matched_ns_ = 0;
  } else if (matched_ns_ == 0) {
    matched_ns_ = now_ns;
  } else if (now_ns - matched_ns_ >= kTimeToMatch_ns) {
    open_.store(true, std::memory_order_relaxed);
  }
}

void StationLink::OnPose(const wire::HapticPose& pose) noexcept {
  // Forces depend on all poses that the loop takes: whoever records its answers needs the first.
  if (!open_.load(std::memory_order_relaxed)) return session_->HearUnanswered();
  const std::int64_t begun_ns = SteadyNanoseconds();
  if (!budget_.Take(begun_ns, alone_.load(std::memory_order_relaxed))) {
    refused_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  if (background_) {
    session_->HearUnanswered();
    return background_->Give(pose);
  }
  Answer(pose);
  const std::int64_t ended_ns = SteadyNanoseconds();
  budget_.Took(ended_ns - begun_ns, ended_ns);
}

void StationLink::Answer(const wire::HapticPose& pose) noexcept {
  if (session_->loop().OnPose(pose, answer_)) wrench_writer_.Write(answer_);
}

}  // namespace palpate
