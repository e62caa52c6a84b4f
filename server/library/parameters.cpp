#include "server/library/parameters.h"

#include <cmath>
#include <limits>
#include <string>
#include <type_traits>

#include "common/error.h"
#include "common/text/nearest_word.h"

namespace palpate {
namespace {

/// Returns the friction of all objects, static and dynamic; not a number if they differ.
double FrictionOf(const Scene& scene) {
  if (scene.features.friction == FrictionModel::kOff || scene.objects.empty()) return 0.0;
  const double mu = scene.objects.front().materials.front().static_friction;
  for (const Body& object : scene.objects) {
    for (const Material& material : object.materials) {
      if (material.static_friction == mu && material.dynamic_friction == mu) continue;
      return std::numeric_limits<double>::quiet_NaN();
    }
  }
  return mu;
}

void SetFriction(Scene& scene, double mu) {
  for (Body& object : scene.objects) {
    for (Material& material : object.materials) {
      material.static_friction = material.dynamic_friction = mu;
    }
  }
  FrictionModel& model = scene.features.friction;
  if (mu > 0.0 && model == FrictionModel::kOff) model = FrictionModel::kCoulomb;
}

/// Returns a value in its unit, without the rounding of its scale.
double NumberOf(const Tunable& tunable, double value) {
  return std::round(value / tunable.scale * 1e9) / 1e9;
}

/// ForEachField without friction, which is not a single number.
template <class AnyScene, class Visit>
void ForEachNumber(AnyScene& scene, Visit visit) {
  visit(kCouplingStiffness, scene.coupling.stiffness);
  visit(kCouplingTorsionalStiffness, scene.coupling.torsional_stiffness);
  ForEachField(scene.tuning, visit);
}

}  // namespace

std::vector<Parameter> ParametersOf(const Scene& scene) {
  std::vector<Parameter> all;
  const Scene plain;
  ForEachNumber(plain, [&](const Tunable& tunable, const auto& number) {
    all.push_back({tunable, NumberOf(tunable, number)});
  });
  auto at = all.begin();
  ForEachNumber(scene, [&](const Tunable& tunable, const auto& number) {
    (at++)->value = NumberOf(tunable, number);
  });
  all.push_back({kFriction, 0.0, FrictionOf(scene)});
  return all;
}

void SetParameter(Scene& scene, std::string_view name, double value) {
  bool found = false;
  std::vector<std::string_view> names;
  const auto is = [&](const Tunable& tunable, bool whole) {
    names.push_back(tunable.name);
    if (name != tunable.name) return false;
    const std::string fault = RangeFault(tunable, value, whole);
    if (!fault.empty()) throw Error("parameter " + fault);
    return found = true;
  };
  ForEachNumber(scene, [&](const Tunable& tunable, auto& number) {
    using Number = std::remove_reference_t<decltype(number)>;
    if (is(tunable, std::is_integral_v<Number>)) {
      number = static_cast<Number>(tunable.scale * value);
    }
  });
  if (is(kFriction, false)) SetFriction(scene, value);
  if (!found) {
    throw Error("parameter " + std::string(name) + " is not known" + DidYouMeanOneOf(name, names));
  }
}

}  // namespace palpate
