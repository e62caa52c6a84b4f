#include "server/session/world.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "server/physics/start_pose.h"

namespace palpate {

PriorityMutex::PriorityMutex() {
  pthread_mutexattr_t attributes;
  pthread_mutexattr_init(&attributes);
  pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT);
  pthread_mutex_init(&mutex_, &attributes);
  pthread_mutexattr_destroy(&attributes);
}

World::World(const std::vector<const HapticModel*>& models) {
  std::vector<const HapticModel*> members = models;
  for (const auto& body : models.front()->free_bodies()) members.push_back(body.get());
  if (members.size() != 1) together_.emplace(members);
  for (std::size_t i = 0; i < members.size(); ++i) {
    const auto set = [&](auto& member, double share) {
      steps_[i].model = member.model;
      steps_[i].state = &member.state;
      steps_[i].workspace = &member.workspace;
      steps_[i].share = share;
    };
    if (i < models.size()) {
      set(*tools_.emplace_back(std::make_unique<Tool>(*members[i])), 0.0);
    } else {
      set(*bodies_.emplace_back(std::make_unique<FreeOne>(*members[i])), 1.0);
    }
  }
}

std::uint32_t World::there() const noexcept {
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < tools_.size(); ++i) bits |= (tools_[i]->hand != 0 ? 1u : 0u) << i;
  return bits;
}

void World::Hear(std::size_t tool, std::uint32_t hand) noexcept {
  ++step_count_;
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    Tool& other = *tools_[i];
    if (other.hand == 0 || other.hand == hand) continue;
    const double patience = other.is_left ? 0.0 : std::max(kPatience, kPauses * other.pause);
    if (++other.silent[tool] > patience) Fade(i);
  }
}

bool World::MeetsOthers(std::size_t tool, const Pose& X_WG) noexcept {
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    const Tool& other = *tools_[i];
    if (i == tool || other.hand == 0) continue;
    const std::size_t first = std::min(i, tool), second = std::max(i, tool);
    const Pose& X_first = first == tool ? X_WG : other.state.X_WG;
    const Pose& X_second = first == tool ? other.state.X_WG : X_WG;
    if (Meet(*tools_[first]->model, X_first, static_cast<std::int32_t>(second), X_second,
             tools_[first]->workspace)) {
      return true;
    }
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (Meet(*tools_[tool]->model, X_WG, static_cast<std::int32_t>(tools_.size() + i),
             bodies_[i]->state.X_WG, tools_[tool]->workspace)) {
      return true;
    }
  }
  return false;
}

bool World::Place(std::size_t tool, std::uint32_t hand, const Pose& X_WG) noexcept {
  Tool& placed = *tools_[tool];
  if (together_) {
    if (placed.hand != 0 && placed.hand != hand) return false;
    LetGo(tool);
    if (there() == 0) {
      for (const auto& body : bodies_) body->state = body->fresh;
    }
    if (MeetsOthers(tool, X_WG)) return false;
    placed.state = placed.fresh;
    placed.pause = kFirstPauses;
  }
  placed.hand = hand;
  placed.state.X_WG = X_WG;
  placed.state.ForgetContact();
  placed.silent.fill(0);
  gain(tool) = 0.0;
  return true;
}

void World::LetGo(std::size_t tool) noexcept {
  tools_[tool]->hand = 0;
  tools_[tool]->is_left = false;
  gain(tool) = 0.0;
  for (std::size_t i = 0; i < tool; ++i) FrameOf(tool, i).Leave();
}

void World::Leave(std::size_t tool, std::uint32_t hand) noexcept {
  ++step_count_;
  if (tools_[tool]->hand == hand) tools_[tool]->is_left = true;
  const auto is_held = [](const auto& one) { return one->hand != 0 && !one->is_left; };
  if (std::ranges::any_of(tools_, is_held)) return;
  for (std::size_t i = 0; i < tools_.size(); ++i) LetGo(i);
}

void World::Fade(std::size_t tool) noexcept {
  gain(tool) = std::max(0.0, gain(tool) - kGainDown);
  if (is_shared() && gain(tool) == 0.0) LetGo(tool);
}

const StepReport& World::Step(std::size_t tool, const Pose& X_WH) noexcept {
  Tool& moved = *tools_[tool];
  ToolStep& step = steps_[tool];
  const double gain = step.share + kGainUp;
  if (together_) {
    moved.pause += (std::ranges::max(moved.silent) - moved.pause) / 8.0;
    moved.silent.fill(0);
    step.share = std::min(1.0, gain);
    step.X_WH = X_WH;
    for (std::size_t i = tools_.size(); i < tools_.size() + bodies_.size(); ++i) {
      steps_[i].period = kPeriod / std::popcount(there());
    }
    StepTogether(std::span(steps_).first(tools_.size() + bodies_.size()), *together_);
  } else {
    step.report = HapticStep(*moved.model, X_WH, moved.state, moved.workspace);
    step.share = gain < 1.0 ? gain : 1.0;
  }
  return step.report;
}

}  // namespace palpate
