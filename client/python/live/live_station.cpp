#include "client/python/live/live_station.h"

#include <exception>
#include <utility>

#include "client/station/servo_thread.h"
#include "client/station/station_core.h"
#include "client/station/statistics_period.h"
#include "common/dds/topics.h"
#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kDevicePoll{10};
constexpr std::chrono::microseconds kDeviceLook{500};
constexpr double kSnapshot_s = 0.05;
constexpr std::size_t kMostNews = 100;

std::string Seconds(double seconds) {
  std::string text = std::to_string(seconds);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text + " s";
}

}  // namespace

std::mutex& MakingParticipants() {
  static std::mutex mutex;
  return mutex;
}

LiveStation::LiveStation(LiveStationOptions options, const WaitOrStop& wait)
    : name_(options.link.station) {
  if (!dds::IsStationName(name_)) {
    throw Error("id '" + name_ + "': give 1 to 32 letters, digits or _");
  }
  options.link.realtime = {.mode = RealtimeMode::kOff};
  {
    const std::lock_guard lock(MakingParticipants());
    dds::ChooseTransport(options.link.transport, options.link.network);
    service_.emplace(dds::Participant::Service(options.link.domain, options.link.network));
  }
  const std::vector<OfferedTool> tools =
      AskForTools(*service_, {options.link.domain, options.link.network, options.link.patience_s},
                  options.link.scene, wait);
  const OfferedTool& meant = Meant(tools, options.link.tool);
  scene_ = options.link.scene = meant.scene;
  device_ = std::make_unique<PosedDevice>(options.start.value_or(meant.Start()),
                                          options.max_force_N, options.max_torque_Nm);
  WrenchLimits::Of(device_->info());  // throws here, since the thread could only report it later
  options.link.device = device_->info().model;
  thread_ = std::thread([this, options = std::move(options)] { Run(options); });
  try {
    for (;;) {
      {
        const std::lock_guard lock(mutex_);
        if (!error_.empty()) throw Error(error_);
        if (phase_ != "asking" && phase_ != "matching") break;
      }
      if (wait(kDevicePoll)) break;
    }
  } catch (...) {
    Close();
    throw;
  }
}

void LiveStation::Run(const LiveStationOptions& options) {
  std::unique_ptr<ServoThread> servo;
  try {
    StationCore core(*device_);
    core.EnableForces(true);
    core.EnableLocalModel(options.local_model);
    ReplyRing replies;
    std::optional<SessionLink> link;
    {
      const std::lock_guard lock(MakingParticipants());
      link.emplace(
          options.link, replies,
          [&]() -> ServoThread& {
            servo = std::make_unique<ServoThread>(core, replies, kSnapshot_s);
            return *servo;
          },
          [this](const std::string& news) { Tell(news); });
    }
    dds::Writer<wire::StationStatistics> statistics(*service_, dds::kStationStatisticsTopic,
                                                    dds::Qos::kStream);
    StatisticsPeriod period(name_, device_->info().model);
    {
      const std::lock_guard lock(mutex_);
      servo_ = servo.get();
    }
    std::exception_ptr over;
    try {
      while (!stop_.load()) {
        {
          // Makes a participant if shared memory fails.
          const std::lock_guard lock(MakingParticipants());
          link->Poll(SteadyNanoseconds());
        }
        StationSnapshot snapshot;
        const bool fresh = servo->ReadSnapshot(snapshot);
        {
          const std::lock_guard lock(mutex_);
          phase_ = link->PhaseText();
          tool_ = link->tool();
          if (fresh) {
            counts_.sent = snapshot.sent;
            counts_.replies += snapshot.replies;
            counts_.lost = snapshot.lost;
          }
        }
        if (fresh) {
          if (const auto figures = period.Add(snapshot, servo->missed_ticks(), link->run())) {
            statistics.Write(*figures);
          }
        }
        std::this_thread::sleep_for(kDevicePoll);
      }
    } catch (...) {
      over = std::current_exception();
    }
    servo->Stop();
    {
      const std::lock_guard lock(mutex_);
      servo_ = nullptr;
    }
    link.reset();
    servo.reset();  // before the core, which its thread uses
    if (over) std::rethrow_exception(over);
    const std::lock_guard lock(mutex_);
    phase_ = "closed";
  } catch (const std::exception& error) {
    Tell(error.what());
    const std::lock_guard lock(mutex_);
    error_ = error.what();
    phase_ = "over";
  }
}

void LiveStation::Tell(const std::string& news) {
  const std::lock_guard lock(mutex_);
  news_.push_back(news);
  if (news_.size() > kMostNews) news_.pop_front();
}

std::vector<std::string> LiveStation::TakeNews() {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> news(news_.begin(), news_.end());
  news_.clear();
  return news;
}

std::string LiveStation::phase() const {
  const std::lock_guard lock(mutex_);
  return phase_;
}

std::string LiveStation::tool() const {
  const std::lock_guard lock(mutex_);
  return tool_;
}

LiveStation::Counts LiveStation::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

Felt LiveStation::Move(const Pose& X_WH, double seconds, double patience_s,
                       const WaitOrStop& wait) {
  if (!(seconds >= 0.0) || seconds > 3600.0) throw Error("seconds: must be 0 to 3600");
  if (!(patience_s > 0.0)) throw Error("timeout: must be above 0");
  if (X_WH.p.cwiseAbs().maxCoeff() > 10.0) {
    throw Error("pose: is more than 10 m from the scene's origin; give it in metres");
  }
  const std::uint64_t number = device_->Go(X_WH, seconds);
  // Only time without any answer counts, not the duration of the move.
  std::int64_t heard_ns = SteadyNanoseconds();
  for (;;) {
    std::int64_t reply_ns = 0;
    {
      const std::lock_guard lock(mutex_);
      if (!error_.empty()) throw Error(error_);
      if (phase_ == "closed" || stop_.load()) throw Error("the station is closed");
      if (servo_ != nullptr) reply_ns = servo_->newest_reply_ns();
    }
    const Felt felt = device_->felt();  // of the tick that took that reply, or of a later one
    if (felt.move > number) throw Error("another thread has moved the hand meanwhile");
    if (felt.move == number && reply_ns >= felt.arrived_ns) return felt;
    const std::int64_t now_ns = SteadyNanoseconds();
    if (reply_ns > heard_ns && felt.move != number) heard_ns = reply_ns;
    if (1e-9 * static_cast<double>(now_ns - heard_ns) > patience_s) {
      const std::string phase = this->phase();
      throw Silence("no replies for " + Seconds(patience_s) +
                    ": forces are zero until they come again (the session: " + phase + ")");
    }
    wait(kDeviceLook);
  }
}

void LiveStation::Close() {
  stop_.store(true);
  if (thread_.joinable()) thread_.join();
}

}  // namespace palpate
