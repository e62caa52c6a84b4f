#include "tests/benchmarks/step_trace.h"

#include <cstddef>
#include <iterator>

#include <spdlog/fmt/fmt.h>

namespace palpate::bench {

std::string StepTrace(std::span<const Pose> X_WH, std::span<const StepReport> steps,
                      std::span<const double> step_us) {
  std::string csv =
      "step,hx,hy,hz,hqw,hqx,hqy,hqz,gx,gy,gz,gqw,gqx,gqy,gqz,fx,fy,fz,tx,ty,tz,contacts,faults,"
      "substeps,step_us\n";
  const auto out = std::back_inserter(csv);
  const auto vector = [&](const Vec3& v) { fmt::format_to(out, ",{},{},{}", v.x(), v.y(), v.z()); };
  const auto pose = [&](const Pose& X) {
    vector(X.p);
    fmt::format_to(out, ",{},{},{},{}", X.q.w(), X.q.x(), X.q.y(), X.q.z());
  };
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const StepReport& step = steps[i];
    fmt::format_to(out, "{}", i);
    pose(X_WH[i]);
    pose(step.X_WG);
    vector(step.wrench.force);
    vector(step.wrench.torque);
    fmt::format_to(out, ",{},{},{},{:.3f}\n", step.contacts, step.faults, step.diagnostics.substeps,
                   step_us[i]);
  }
  return csv;
}

}  // namespace palpate::bench
