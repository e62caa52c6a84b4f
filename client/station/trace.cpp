#include "client/station/trace.h"

#include <chrono>
#include <cinttypes>
#include <utility>

#include "common/error.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kPause{20};

constexpr const char* kHeader =
    "time_ns,tick,pose,reply,age_ms,silence_ms,"
    "wanted_fx_N,wanted_fy_N,wanted_fz_N,wanted_tx_Nm,wanted_ty_Nm,wanted_tz_Nm,"
    "applied_fx_N,applied_fy_N,applied_fz_N,applied_tx_Nm,applied_ty_Nm,applied_tz_Nm,limiter\n";

struct Stage {
  std::uint64_t LimiterCounts::*count;
  const char* name;
};
constexpr Stage kStages[] = {
    {&LimiterCounts::nonfinite, "finite"}, {&LimiterCounts::clamped, "clamp"},
    {&LimiterCounts::slewed, "slew"},      {&LimiterCounts::braked, "energy"},
    {&LimiterCounts::warm, "temperature"}, {&LimiterCounts::faded, "age"},
    {&LimiterCounts::disabled, "enable"}};

void WriteVec3(std::FILE* out, const Vec3& v) {
  std::fprintf(out, "%.9g,%.9g,%.9g,", v.x(), v.y(), v.z());
}

/// The tick's time also stands for its end, so a reply that came within the tick has age 0.
void WriteSince(std::FILE* out, std::int64_t now_ns, std::int64_t then_ns) {
  std::fprintf(out, "%.6f,", then_ns < now_ns ? 1e-6 * static_cast<double>(now_ns - then_ns) : 0.0);
}

void WriteStages(std::FILE* out, const LimiterCounts& before, const LimiterCounts& now) {
  const char* separator = "";
  for (const Stage& stage : kStages) {
    if (now.*stage.count == before.*stage.count) continue;
    std::fprintf(out, "%s%s", separator, stage.name);
    separator = "+";
  }
}

}  // namespace

Trace::Trace(std::string file) : file_(std::move(file)), out_(std::fopen(file_.c_str(), "w")) {
  if (out_ == nullptr) {
    throw Error("--trace " + file_ + ": cannot be written; give a file in a folder that exists");
  }
  std::fputs(kHeader, out_);
  thread_ = std::thread([this] { Run(); });
}

Trace::~Trace() {
  try {
    Close();
  } catch (const Error&) {
  }
}

void Trace::Add(const TickRecord& record) noexcept {
  if (!records_.Push(record)) dropped_.fetch_add(1, std::memory_order_relaxed);
}

void Trace::Close() {
  if (out_ == nullptr) return;
  stop_.store(true);
  thread_.join();
  Drain();
  const bool taken = std::ferror(out_) == 0;
  const bool closed = std::fclose(std::exchange(out_, nullptr)) == 0;
  if (!taken || !closed) {
    throw Error("--trace " + file_ + ": rows are missing; check that the disk is not full");
  }
}

void Trace::Run() {
  while (!stop_.load()) {
    Drain();
    std::this_thread::sleep_for(kPause);
  }
}

void Trace::Drain() {
  TickRecord r;
  while (records_.Pop(r)) {
    std::fprintf(out_, "%" PRId64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",", r.time_ns,
                 r.limiter.calls, r.pose_sequence, r.reply_sequence);
    if (r.reply_sequence == 0) {
      std::fputs(",,", out_);
    } else {
      WriteSince(out_, r.time_ns, r.reply_pose_time_ns);
      WriteSince(out_, r.time_ns, r.reply_received_ns);
    }
    for (const Wrench& wrench : {r.wanted, r.applied}) {
      WriteVec3(out_, wrench.force);
      WriteVec3(out_, wrench.torque);
    }
    WriteStages(out_, before_, r.limiter);
    std::fputc('\n', out_);
    before_ = r.limiter;
  }
}

}  // namespace palpate
