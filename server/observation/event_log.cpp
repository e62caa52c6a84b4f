#include "server/observation/event_log.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/dds/phase_name.h"
#include "common/error.h"
#include "common/program/log.h"
#include "common/step_fault.h"
#include "common/text/hex16.h"

namespace palpate {
namespace {

/// Up to this size no old entries are removed.
constexpr std::size_t kMostReported = 1000;
constexpr std::uint32_t kUsualFaults = kFaultTargetFar | kFaultNotStarted;

void PutField(std::string& line, const char* name, const std::string& value) {
  line.append(line.empty() ? "{\"" : ",\"").append(name).append("\":\"");
  line.append(JsonEscaped(value)).append("\"");
}

}  // namespace

EventLog::EventLog(const std::string& file) : file_(file) {
  fd_ = open(file.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC | O_NONBLOCK, 0640);
  if (fd_ < 0) {
    throw Error("--event-log " + file + ": " + std::strerror(errno) +
                "; give a file in a writable folder");
  }
}

EventLog::~EventLog() {
  if (started_) Write("stop", {});
  close(fd_);
}

void EventLog::OnStart(const Fields& fields) {
  started_ = true;
  Write("start", fields);
}

void EventLog::OnSession(const wire::SessionState& state, std::int64_t now_ns) {
  const std::string station = state.station;
  const char* event = state.phase == palpate_SESSION_WAITING ? "begun" : PhaseName(state.phase);
  if (state.phase == palpate_SESSION_ENDED) {
    const auto known = sessions_.find(station);
    if (known == sessions_.end() || known->second.run != state.run) return;
    sessions_.erase(known);
    faults_.erase(station);
  } else if (state.phase != palpate_SESSION_REFUSED && state.phase != palpate_SESSION_HELD) {
    const Session now{state.run, state.phase, state.muted};
    const auto [known, is_new] = sessions_.try_emplace(station, now);
    const Session before = std::exchange(known->second, now);
    if (!is_new && before == now) return;
    const bool only_muted = !is_new && before.run == now.run && before.phase == now.phase;
    if (only_muted) event = now.muted ? "muted" : "unmuted";
  }
  Fields fields{{"station", station},
                {"run", Hex16(state.run)},
                {"scene", state.scene},
                {"tool", state.tool}};
  if (state.reason[0] != '\0') fields.emplace_back("reason", state.reason);
  if (state.muted) fields.emplace_back("muted", "yes");
  Tell(event, station, fields, now_ns);
}

void EventLog::OnWhole(const wire::SceneWhole& whole, std::int64_t now_ns) {
  const bool refused = whole.refusal[0] != '\0';
  Fields fields{{"scene", whole.scene}, {"by", whole.by}};
  if (refused) fields.emplace_back("reason", whole.refusal);
  const char* const done = whole.wish == palpate_WHOLE_BOOKMARK ? "bookmark"
                           : whole.wish == palpate_WHOLE_BACK   ? "back"
                                                                : "whole";
  Tell(refused ? "refused" : done, whole.scene, fields, now_ns);
}

void EventLog::OnStatistics(const wire::LoopStatistics& statistics, std::int64_t now_ns) {
  std::uint32_t& before = faults_[statistics.station];
  const std::uint32_t fresh = statistics.faults & ~before & ~kUsualFaults;
  before = statistics.faults;
  if (fresh == 0) return;
  Tell(
      "fault", statistics.station,
      {{"station", statistics.station}, {"scene", statistics.scene}, {"faults", FaultWords(fresh)}},
      now_ns);
}

void EventLog::Tell(const char* event, const std::string& station, const Fields& fields,
                    std::int64_t now_ns) {
  Budget& budget = budgets_[event];
  if (budget.written == 0 || now_ns - budget.since_ns >= kApart_ns) budget = {now_ns, 0};
  if (reported_.size() > kMostReported) {
    std::erase_if(reported_, [&](const auto& entry) { return now_ns - entry.second >= kApart_ns; });
  }
  const auto reported = reported_.find({event, station});
  const bool is_apart = reported == reported_.end() || now_ns - reported->second >= kApart_ns;
  if (!is_apart || budget.written >= kMostOfAKind) {
    ++left_out_;
    return;
  }
  ++budget.written;
  reported_[{event, station}] = now_ns;
  Write(event, fields);
}

void EventLog::Write(const char* event, const Fields& fields) {
  std::string line;
  PutField(line, "time", UtcTime());
  PutField(line, "event", event);
  for (const auto& [name, value] : fields) PutField(line, name, value);
  if (left_out_ > 0) line += ",\"left_out\":" + std::to_string(left_out_);
  line += "}\n";
  if (Append(line)) {
    left_out_ = 0;
    if (std::exchange(failing_, false)) spdlog::info("{}: events are written again", file_);
    return;
  }
  const std::string why = std::strerror(errno);
  ++left_out_;
  if (!std::exchange(failing_, true)) {
    spdlog::error("{}: {}: no events are written until this is fixed; the server continues", file_,
                  why);
  }
}

/// Writes the whole line or nothing.
bool EventLog::Append(const std::string& line) {
  struct stat before {};
  const bool is_file = fstat(fd_, &before) == 0 && S_ISREG(before.st_mode);
  const ssize_t written = write(fd_, line.data(), line.size());
  if (written == static_cast<ssize_t>(line.size())) return true;
  if (written >= 0) {
    // Half a line would spoil the next one, too.
    if (is_file && ftruncate(fd_, before.st_size) != 0) return false;
    errno = ENOSPC;
  }
  return false;
}

}  // namespace palpate
