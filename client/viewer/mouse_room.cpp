#include "client/viewer/mouse_room.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "client/viewer/tokens.h"
#include "client/viewer/topic_feed.h"
#include "client/viewer/viewer_limits.h"
#include "common/dds/phase_name.h"
#include "common/error.h"

namespace palpate {

MouseRoom::Mouse* MouseRoom::Find(Holder holder) {
  const auto found = std::ranges::find(mice_, holder, &Mouse::holder);
  return found == mice_.end() ? nullptr : &*found;
}

std::string MouseRoom::NameFor(const std::string& who, const Mouse& wanted) const {
  for (int number = 1;; ++number) {
    const std::string name = who.empty() ? options_.prefix + std::to_string(number)
                                         : StationNameOf(options_.named_prefix + who, number);
    bool is_own = false;
    bool is_free = true;
    for (const Mouse& mouse : mice_) {
      if (mouse.name != name) continue;
      is_own = true;
      is_free = is_free && !who.empty() && Leaves(mouse, wanted);
    }
    if (is_own ? is_free : !options_.is_others(name, who)) return name;
  }
}

std::string MouseRoom::Take(Holder holder, const std::string& who, const MouseCommand& command,
                            const std::string& absent, std::int64_t now_ns, bool waits) {
  const auto refuse = [&](const std::string& reason) {
    tell_({holder, "", command.scene, command.tool, "refused", reason});
    return std::string();
  };
  if (const Mouse* held = Find(holder)) {
    return refuse("you hold a tool of scene '" + held->scene + "' already; release it first");
  }
  if (!absent.empty()) return refuse(absent);
  if (mice_.size() >= static_cast<std::size_t>(options_.most)) {
    return refuse(std::to_string(mice_.size()) +
                  " tools are held with the mouse, the most that this gateway allows "
                  "(--max-mice); wait until one is released");
  }
  Mouse mouse;
  mouse.holder = holder;
  mouse.scene = command.scene;
  mouse.tool = command.tool;
  mouse.moved_ns = now_ns;
  mouse.waits = waits;
  mouse.name = NameFor(who, mouse);
  const std::string of = options_.name_of(holder);
  mouse.logged = of.empty() ? mouse.name : of + " (" + mouse.name + ")";
  spdlog::info("{} takes a tool of scene '{}'", mouse.logged, command.scene);
  tell_({holder, mouse.name, command.scene, command.tool, "", ""});
  std::string name = mouse.name;
  mice_.push_back(std::move(mouse));
  if (!waits && !StillHeld(mice_.back())) Start(mice_.back(), now_ns);
  return name;
}

bool MouseRoom::IsTaken(const std::string& scene, const std::string& tool, Holder holder) const {
  return std::ranges::any_of(mice_, [&](const Mouse& mouse) {
    return mouse.holder != 0 && mouse.holder != holder && mouse.scene == scene &&
           (tool.empty() || mouse.tool.empty() || mouse.tool == tool);
  });
}

std::string MouseRoom::StationOf(Holder holder) const {
  const auto found = std::ranges::find(mice_, holder, &Mouse::holder);
  return found == mice_.end() ? "" : found->name;
}

void MouseRoom::Go(Holder holder, std::int64_t now_ns) {
  Mouse* const mouse = Find(holder);
  if (mouse == nullptr) return;
  mouse->waits = false;
  mouse->recorded = true;
  mouse->moved_ns = now_ns;
}

bool MouseRoom::Leaves(const Mouse& mouse, const Mouse& wanted) {
  return mouse.holder == 0 && mouse.scene == wanted.scene &&
         (mouse.tool == wanted.tool || mouse.tool.empty() || wanted.tool.empty());
}

bool MouseRoom::StillHeld(const Mouse& wanted) const {
  return std::ranges::any_of(mice_, [&](const Mouse& mouse) { return Leaves(mouse, wanted); });
}

void MouseRoom::Start(Mouse& mouse, std::int64_t now_ns) {
  // Each as one word, so that text from a page can never be an option.
  std::vector<std::string> arguments{
      "--device=mouse", "--scene=" + mouse.scene, "--id=" + mouse.name,
      "--domain=" + std::to_string(options_.domain), "--transport=" + options_.transport,
      "--network=" + options_.network.interface,
      // A mouse's hand feels nothing.  A dozen real-time loops on two cores would leave no time to
      // recorders, to this gateway, and to what answers mice in the server.
      "--realtime=off",
      // The gateway hears the server already; twenty stations that
      // begin at once on two cores look for it for longer than 10 s.
      "--wait=30", "--no-table"};
  if (mouse.recorded) {
    arguments.insert(arguments.end(), {"--await-recorder", "--keep-scene"});
  }
  if (options_.network.secured()) arguments.push_back("--identity=" + options_.network.identity);
  for (const std::string& peer : options_.network.peers) arguments.push_back("--peer=" + peer);
  if (!mouse.tool.empty()) arguments.push_back("--tool=" + mouse.tool);
  try {
    mouse.station = std::make_unique<MouseStation>(options_.program, arguments);
  } catch (const Error& error) {
    LetGo(mouse, "refused", error.what(), now_ns);
  }
}

void MouseRoom::Drag(Holder holder, const Pose& X_WT, bool still, std::int64_t now_ns) {
  Mouse* const mouse = Find(holder);
  if (mouse == nullptr) return;
  mouse->moved_ns = now_ns;
  if (mouse->station) mouse->station->Drag(X_WT, still);
}

void MouseRoom::LetGo(Mouse& mouse, const std::string& phase, const std::string& reason,
                      std::int64_t now_ns, bool lost) {
  const Holder holder = std::exchange(mouse.holder, 0);
  if (mouse.station) mouse.station->LetGo(now_ns);
  spdlog::info("{} {}{}{}", mouse.logged, phase, reason.empty() ? "" : ": ", reason);
  tell_({holder, mouse.name, mouse.scene, mouse.tool, phase, reason, lost});
}

void MouseRoom::Rest(Holder holder, std::int64_t now_ns) {
  Mouse* const mouse = Find(holder);
  if (mouse == nullptr || mouse->away_ns != 0) return;
  mouse->away_ns = now_ns;
  if (mouse->station) mouse->station->Rest();
  spdlog::info("{} rests: its page is missing", mouse->logged);
}

bool MouseRoom::Return(Holder holder, Holder to, std::int64_t now_ns) {
  Mouse* const mouse = Find(holder);
  if (mouse == nullptr || mouse->away_ns == 0) return false;
  mouse->holder = to;
  mouse->away_ns = 0;
  mouse->moved_ns = now_ns;
  spdlog::info("{} goes on: its page is back", mouse->logged);
  tell_({to, mouse->name, mouse->scene, mouse->tool, mouse->phase, ""});
  return true;
}

void MouseRoom::Release(Holder holder, const std::string& reason, std::int64_t now_ns) {
  for (Mouse& mouse : mice_) {
    const bool is_meant = holder == 0 || mouse.holder == holder;
    if (mouse.holder != 0 && is_meant) LetGo(mouse, "ended", reason, now_ns);
  }
}

void MouseRoom::OnSession(const wire::SessionState& state, std::int64_t now_ns) {
  for (Mouse& mouse : mice_) {
    if (mouse.holder == 0 || !mouse.station || mouse.name != state.station) continue;
    const bool ended = state.phase == palpate_SESSION_ENDED;
    if (state.phase == palpate_SESSION_REFUSED) {
      // A station that has had its session retries by itself, and reports when it gives up.
      if (mouse.run == 0) return LetGo(mouse, "refused", state.reason, now_ns);
      continue;
    }
    // The end of another run is that of a predecessor with the same name.
    if (ended && state.run != mouse.run) continue;
    mouse.run = state.run;  // it changes with each retry
    mouse.tool = state.tool;
    if (mouse.held) mouse.moved_ns = now_ns;
    mouse.held = state.phase == palpate_SESSION_HELD;
    // A station whose session the server ended retries by itself: its tool is not lost yet.
    mouse.phase = ended ? "" : PhaseName(state.phase);
    tell_({mouse.holder, mouse.name, mouse.scene, mouse.tool, mouse.phase, state.reason});
  }
}

void MouseRoom::Poll(std::int64_t now_ns) {
  for (auto it = mice_.begin(); it != mice_.end();) {
    Mouse& mouse = *it;
    if (mouse.holder != 0 && !mouse.held && now_ns - mouse.moved_ns > ViewerLimits::kMouseIdle_ns) {
      LetGo(mouse, "ended", "nobody has moved it for 5 minutes", now_ns);
    }
    if (mouse.holder != 0 && mouse.away_ns != 0 &&
        now_ns - mouse.away_ns > ViewerLimits::kMouseAway_ns) {
      LetGo(mouse, "ended", "its page did not come back within 30 s", now_ns, true);
    }
    const bool may_start = !mouse.station && mouse.holder != 0 && !mouse.waits;
    if (may_start && !StillHeld(mouse)) Start(mouse, now_ns);
    const bool waits = !mouse.station && mouse.holder != 0;
    if (waits || (mouse.station && mouse.station->Poll(now_ns))) {
      ++it;
      continue;
    }
    if (mouse.holder != 0) {
      const std::string& complaint = mouse.station->complaint();
      LetGo(mouse, complaint.empty() ? "ended" : "refused", complaint, now_ns);
    }
    it = mice_.erase(it);
  }
}

FramePtr MouseStateFrame(const MouseRoom::News& news) {
  return OwnFrame(TopicFeed::kMouseState, 0,
                  ToText(nlohmann::json({{"station", news.station},
                                         {"scene", news.scene},
                                         {"tool", news.tool},
                                         {"phase", news.phase},
                                         {"reason", news.reason}})));
}

}  // namespace palpate
