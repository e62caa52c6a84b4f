#include "server/physics/limits.h"
#include "server/physics/solve/stages.h"

namespace palpate {
namespace {

bool Predict(StepContext& context, const StepEnds& ends, bool may_crowd = true) {
  StepBuffers& buffers = context.buffers();
  const Tools& tools = context.tools;
  StageTimes* times = context.sub_step.iterates == 0 ? context.times : nullptr;
  const std::int64_t before = buffers.prediction.tested();
  const bool fits = buffers.prediction.Predict(context.model, context.kernels, tools.R_WG,
                                               tools.p_G, ends, buffers.rows, times, may_crowd);
  context.sub_step.ends = ends;
  context.cost.last = buffers.prediction.tested() - before;
  context.cost.packet_pairs += context.cost.last;
  context.report().diagnostics.predicted_pairs = buffers.rows.count();
  return fits;
}

/// Predicts within bounds that are halved until all rows fit; returns the bounds.  If even the
/// narrowest have too many, some rows are left out: a tool that stayed could never leave.
StepBounds PredictAsFits(StepContext& context, StepBounds bounds) {
  for (int halvings = 0; !Predict(context, {bounds}); ++halvings) {
    if (halvings == limits::kMostHalvings) {
      context.report().faults |= kFaultRowsFull;
      context.cost.packet_pairs += limits::kMaxTested;  // no further sub-step
      return bounds;
    }
    bounds = {0.5 * bounds.translation, 0.5 * bounds.rotation};
  }
  return bounds;
}

/// Returns how far from where the tool is expected a sub-step whose rows are predicted there may
/// end.
StepBounds Reach(const StepContext& context) {
  const StepParameters& parameters = context.model.parameters();
  return {limits::kReachAhead * parameters.widest_step,
          limits::kReachAhead * parameters.max_rotation};
}

/// Begins with the rows of the contacts of the last cycle, or of what touches if there were none.
void PredictContacts(StepContext& context) {
  if (context.sub_step.active.count == 0) {
    PredictAsFits(context, Reach(context));
    return;
  }
  context.buffers().prediction.Take(context.model, context.kernels, context.tools.R_WG,
                                    context.tools.p_G, context.sub_step.active,
                                    context.buffers().rows);
  context.sub_step.ends = {{-1.0, -1.0}};  // no motion
}

}  // namespace

void PredictLeaves(StepContext& context) noexcept {
  SubStep& sub_step = context.sub_step;
  const StepParameters& parameters = context.model.parameters();
  const bool may_predict_ahead = !context.buffers().meshes && !context.buffers().energies;
  if (!may_predict_ahead) {
    sub_step.bounds = PredictAsFits(context, sub_step.bounds);
    return;
  }
  if (!sub_step.is_crowded && Predict(context, {sub_step.bounds}, false)) return;
  sub_step.bounds_before = sub_step.bounds;
  sub_step.bounds = {parameters.widest_step, parameters.max_rotation};
  sub_step.predictions = 1;
  PredictContacts(context);
}

bool Foresees(StepContext& context) noexcept {
  const Advance& advance = context.advance;
  SubStep& sub_step = context.sub_step;
  if (sub_step.predictions == 0) return true;
  const StepEnds& ends = sub_step.ends;
  if (FractionWithin(ends.bounds, advance.v - ends.v, advance.phi - ends.phi) == 1.0) {
    sub_step.is_crowded = context.buffers().rows.count() >= limits::kFew;
    return true;
  }
  if (sub_step.predictions++ == limits::kMostPredictions) {
    sub_step.predictions = 0;
    sub_step.bounds = PredictAsFits(context, sub_step.bounds_before);
    sub_step.is_crowded = false;
  } else if (!Predict(context, {Reach(context), advance.v, advance.phi})) {
    sub_step.bounds = {0.5 * advance.v.norm(), 0.5 * advance.phi.norm()};
    PredictContacts(context);
  }
  return false;
}

}  // namespace palpate
