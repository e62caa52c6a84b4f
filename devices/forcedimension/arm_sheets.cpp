#include <algorithm>
#include <initializer_list>

#include "devices/forcedimension/forcedimension_device.h"

namespace palpate {
namespace {

constexpr double kMilli = 1e-3;
constexpr double kDegree = 3.14159265358979 / 180.0;

// [S] as the maker's data sheet is commonly quoted; no sheet was available, so check it.  [C] the
// value of CHAI3D 3's public driver.  If both are known and differ, the lower one bounds the force.
// The maker gives a single force, as continuous, so the peak is no higher.  [E] estimate.
struct Row {
  double force_N, torque_Nm;
  double across_m, along_m;  ///< diameter of the reach beside, and its depth towards the user
  double position_m, rotation_deg;
  double stiffness_N_m;
};

constexpr Row kOmega{12.0, 0.0, 0.160, 0.110, 0.01 * kMilli, 0.09, 14500.0};      // S (C: 12 N)
constexpr Row kDelta{20.0, 0.2, 0.400, 0.260, 0.03 * kMilli, 0.04, 14500.0};      // S, C; torque C
constexpr Row kSigma{12.0, 0.2, 0.190, 0.130, 0.0015 * kMilli, 0.013, 14500.0};   // C; S: 20, 0.4
constexpr Row kLambda{12.0, 0.2, 0.240, 0.170, 0.0015 * kMilli, 0.013, 14500.0};  // as sigma; S: 20
constexpr Row kFalconRow{8.0, 0.0, 0.100, 0.100, 0.06 * kMilli, 0.0, 3000.0};     // C; reach S
constexpr Row kUnknown{5.0, 0.05, 0.100, 0.100, 0.06 * kMilli, 0.1, 3000.0};      // E

Row RowOf(int system_type) {
  const auto among = [system_type](std::initializer_list<int> types) {
    return std::ranges::find(types, system_type) != types.end();
  };
  using namespace dhd;
  if (among({kOmega3, kOmega6, kOmega6Left, kOmega7, kOmega7Left})) return kOmega;
  if (among({kDelta3, kDelta6})) return kDelta;
  if (among({kSigma3, kSigma7, kSigma7Left, kSigma6Plus, kSigma6PlusLeft})) return kSigma;
  if (among({kLambda3, kLambda7, kLambda7Left})) return kLambda;
  return system_type == kFalcon ? kFalconRow : kUnknown;
}

}  // namespace

DeviceInfo ForceDimensionSheet(int system_type) {
  const Row row = RowOf(system_type);
  DeviceInfo info;
  info.max_force_N = info.continuous_force_N = row.force_N;
  info.max_torque_Nm = info.continuous_torque_Nm = row.torque_Nm;
  info.workspace_m = Vec3(row.across_m, row.across_m, row.along_m);
  info.position_resolution_m = row.position_m;
  info.rotation_resolution_rad = row.rotation_deg * kDegree;
  info.max_stiffness_N_m = row.stiffness_N_m;
  return info;
}

}  // namespace palpate
