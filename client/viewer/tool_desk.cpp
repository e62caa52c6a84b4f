#include "client/viewer/tool_desk.h"

#include "common/text/quoted.h"

namespace palpate {

void ToolDesk::Take(Viewer& viewer, const MouseCommand& command, std::int64_t now_ns) {
  std::string refusal = viewers_.Refuse(Wish::kTake, viewer, now_ns);
  if (refusal.empty() && course_ != nullptr) refusal = course_->WhyNotTake(viewer, command.scene);
  if (refusal.empty()) {
    const auto& holder = viewer.guest().holder;
    mice_.Take(viewer.id(), holder ? holder->station : "", command, feed_.WhyAbsent(command.scene),
               now_ns);
    return;
  }
  // The page expects an answer to each; the newest one suffices.
  viewer.TellMouseState(
      MouseStateFrame({viewer.id(), "", command.scene, command.tool, "refused", refusal}));
}

void ToolDesk::Restore(Viewer& viewer, const MouseCommand& command, std::int64_t now_ns) {
  if (!viewers_.Refuse(Wish::kWhole, viewer, now_ns).empty()) return;
  if (course_ != nullptr) {
    if (const std::string why = course_->WhyNotRestore(viewer, command.scene); !why.empty()) {
      return viewer.Say(foxglove::Level::kError, why);
    }
  }
  const wire::WholeWish wish = command.op == MouseCommand::Op::kWhole  ? palpate_WHOLE_AGAIN
                               : command.op == MouseCommand::Op::kBack ? palpate_WHOLE_BACK
                                                                       : palpate_WHOLE_BOOKMARK;
  if (!feed_.AskForWhole(command.scene, wish, viewer.guest().Who())) {
    viewer.Say(foxglove::Level::kError, "scene " + Quoted(command.scene) + " is not served here");
  }
}

void ToolDesk::Miss(std::uint64_t id, const std::string& reason, std::int64_t now_ns) {
  if (course_ != nullptr) {
    TrialRoom& trials = course_->trials();
    if (trials.now().is_running(id) && mice_.holds(id)) return mice_.Rest(id, now_ns);
    trials.End(id, reason);
  }
  mice_.Release(id, reason, now_ns);
}

void ToolDesk::Return(const Viewer& viewer, std::int64_t now_ns) {
  if (course_ == nullptr || !viewer.guest().holder || mice_.holds(viewer.id())) return;
  TrialRoom& trials = course_->trials();
  const std::uint64_t holder = trials.now().HolderOf(viewer.guest().person());
  if (holder == 0 || !mice_.Return(holder, viewer.id(), now_ns)) return;
  trials.Return(holder, viewer.id(), now_ns);
}

void ToolDesk::Hear(const MouseRoom::News& news) {
  if (course_ != nullptr && (news.phase == "ended" || news.phase == "refused")) {
    const std::string what = news.lost               ? "cut short"
                             : news.phase == "ended" ? "the tool is given back"
                                                     : "the tool is refused";
    course_->trials().End(news.holder, what + (news.reason.empty() ? "" : ": " + news.reason),
                          !news.lost);
  }
  const auto viewer = viewers_.all().find(news.holder);
  if (viewer == viewers_.all().end()) return;
  const std::shared_ptr<Viewer> keep = viewer->second;
  viewers_.places().Holds(news.holder, mice_.holds(news.holder));
  if (course_ != nullptr) course_->NoteChange();  // who holds a tool is named
  if (news.phase == "refused") {
    keep->Say(foxglove::Level::kError, "the tool is refused: " + news.reason);
  }
  keep->TellMouseState(MouseStateFrame(news));
}

void ToolDesk::Hear(const wire::SceneWhole& whole, bool is_own) {
  // Without a request: a station's session began in a scene that is then made whole.
  if (course_ == nullptr || whole.request == 0 || whole.wish == palpate_WHOLE_BOOKMARK) return;
  TrialRoom& trials = course_->trials();
  const bool is_refused = whole.refusal[0] != '\0';
  // A trial that begins in the state that another one left would be worth nothing.
  if (is_own && is_refused) {
    trials.EndIn(whole.scene, std::string("the scene is not restored: ") + whole.refusal);
  }
  // The server refuses it once the trial's station has its tool, so it was just before.
  if (!is_own && !is_refused) {
    trials.EndIn(whole.scene, std::string(whole.by) + " restored the scene, past this gateway");
  }
}

}  // namespace palpate
