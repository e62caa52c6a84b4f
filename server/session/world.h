#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <pthread.h>

#include "server/physics/haptic_step.h"
#include "server/physics/step_state.h"

namespace palpate {

/// A mutex whose holder runs with the priority of the thread that waits for it most urgently.
class PriorityMutex {
 public:
  PriorityMutex();
  ~PriorityMutex() { pthread_mutex_destroy(&mutex_); }
  PriorityMutex(const PriorityMutex&) = delete;
  void lock() noexcept { pthread_mutex_lock(&mutex_); }
  void unlock() noexcept { pthread_mutex_unlock(&mutex_); }

 private:
  pthread_mutex_t mutex_;
};

/// The tools that are stepped together when a pose of any of their hands comes: one tool alone, or
/// all of a scene whose hands meet (Scene::hands_meet); and the scene's free bodies, for which a
/// millisecond passes with one pose of each hand that is there.  They rest until the first tool is
/// there, and go back when it comes again.  README.md, "Hands that meet", explains it.
///
/// A tool is there from Place until it is let go.  What a step does depends on the order in which
/// poses have come, and on nothing else.
///
/// Thread contract: everything but MakeHand during a Turn.
class World {
 public:
  /// How many poses of another hand a tool waits for its own, before its spring fades: at least
  /// these, and so many times as many as it usually takes, as that of a mouse beside an arm.
  static constexpr double kPatience = 25.0;
  static constexpr double kPauses = 8.0;
  static constexpr double kFirstPauses = 12.0;    ///< what a new hand is taken to need
  static constexpr double kPeriod = 1e-3;         ///< of a hand's poses [s]
  static constexpr double kGainUp = 1.0 / 200.0;  ///< per pose: 200 ms from none to full force
  static constexpr double kGainDown = 1.0 / 20.0;

  /// The models of all tools, which must outlive this.  Throws Error if they cannot be stepped
  /// together.
  explicit World(const std::vector<const HapticModel*>& models);

  /// The time in which one thread steps the world.  Real-time: it waits for other hands' steps.
  class Turn {
   public:
    explicit Turn(World& world) : world_(world.is_shared() ? &world : nullptr) {
      if (world_ != nullptr) world_->mutex_.lock();
    }
    ~Turn() {
      if (world_ != nullptr) world_->mutex_.unlock();
    }
    Turn(const Turn&) = delete;

   private:
    World* world_;
  };

  /// Returns a number for a hand that will hold a tool, which no other has.
  std::uint32_t MakeHand() noexcept { return ++hands_; }

  bool is_shared() const { return tools_.size() > 1; }
  /// Counts a pose that came to a tool from a hand, whatever becomes of it.  Tools whose own hands
  /// have been silent for long fade, and are let go.
  void Hear(std::size_t tool, std::uint32_t hand) noexcept;
  /// Lets a hand hold a tool, at a pose that is free of all objects.  Returns false if another
  /// still holds it, or if another tool is there.
  bool Place(std::size_t tool, std::uint32_t hand, const Pose& X_WG) noexcept;
  bool Holds(std::size_t tool, std::uint32_t hand) const { return tools_[tool]->hand == hand; }
  void LetGo(std::size_t tool) noexcept;
  /// Ends a hand after its last pose, which counts as a step: its tool fades with the poses of the
  /// others or, if no other hand is left, is gone.
  void Leave(std::size_t tool, std::uint32_t hand) noexcept;
  /// Weakens the spring of a tool whose pose cannot be used; at no strength, several hands let go.
  void Fade(std::size_t tool) noexcept;
  /// Steps all tools that are there, this one to a new pose of its hand, and strengthens its
  /// spring.  The report's forces are those of the whole spring.
  const StepReport& Step(std::size_t tool, const Pose& X_WH) noexcept;

  const HapticModel& model(std::size_t tool) const { return *tools_[tool]->model; }
  StepState& state(std::size_t tool) { return tools_[tool]->state; }
  /// The part of a tool's spring that acts, 0 to 1.
  double& gain(std::size_t tool) { return steps_[tool].share; }
  std::uint64_t steps() const { return step_count_; }  ///< number of poses heard, and of leaves
  /// For a replay: takes up the count where no tool is there.
  void BeginAt(std::uint64_t steps) { step_count_ = steps; }
  std::uint32_t there() const noexcept;  ///< bit i: tool i is there

 private:
  struct Tool {
    explicit Tool(const HapticModel& of) : model(&of), workspace(of), fresh(of), state(of) {}
    const HapticModel* model;
    StepWorkspace workspace;
    const StepState fresh;
    StepState state;
    std::uint32_t hand = 0;  ///< that holds it; 0: it is not there
    /// By tool: number of poses of others that have come to it since this one's last.
    std::array<std::uint32_t, kMostTools> silent{};
    bool is_left = false;         ///< its hand has left
    double pause = kFirstPauses;  ///< usual greatest of these, when its own pose comes
  };
  /// A free body.
  struct FreeOne {
    explicit FreeOne(const HapticModel& of) : model(&of), workspace(of), fresh(of), state(of) {}
    const HapticModel* model;
    StepWorkspace workspace;
    const StepState fresh;
    StepState state;
  };
  /// The frame of a tool in the model of one that is listed before it.
  BodyFrame& FrameOf(std::size_t tool, std::size_t before) {
    return tools_[before]->state.frames[model(before).moved().size() + tool - before];
  }
  bool MeetsOthers(std::size_t tool, const Pose& X_WG) noexcept;

  std::vector<std::unique_ptr<Tool>> tools_;
  std::vector<std::unique_ptr<FreeOne>> bodies_;
  std::array<ToolStep, kMostMembers> steps_;  // of tools_, whose `share` is the gain, then bodies_
  std::optional<TogetherWorkspace> together_;
  std::uint64_t step_count_ = 0;
  std::atomic<std::uint32_t> hands_{0};
  PriorityMutex mutex_;
};

}  // namespace palpate
