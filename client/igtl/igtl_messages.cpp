#include "client/igtl/igtl_messages.h"

#include <Eigen/Geometry>
#include <igtlSensorMessage.h>
#include <igtlTimeStamp.h>
#include <igtlTransformMessage.h>
#include <igtlUnit.h>
#include <spdlog/fmt/fmt.h>

namespace palpate {
namespace {

constexpr std::size_t kNameLetters = 13;
constexpr std::size_t kNameBegin = 9;

/// Returns the rotation from the scene's frame W, y up and z forward, to RAS: right,
/// anterior, superior.
Eigen::Matrix3d SceneToRas() {
  Eigen::Matrix3d C;
  C << -1, 0, 0, 0, 0, 1, 0, 1, 0;
  return C;
}

void Append(igtl::MessageBase& message, const std::string& name, std::int64_t system_ns,
            std::vector<std::uint8_t>& out) {
  message.SetDeviceName(name.c_str());
  igtl::TimeStamp::Pointer time = igtl::TimeStamp::New();
  time->SetTime(static_cast<igtlUint32>(system_ns / 1'000'000'000),
                static_cast<igtlUint32>(system_ns % 1'000'000'000));
  message.SetTimeStamp(time);
  message.Pack();
  const auto* const bytes = static_cast<const std::uint8_t*>(message.GetPackPointer());
  out.insert(out.end(), bytes, bytes + message.GetPackSize());
}

void AppendSensor(const std::string& name, const Vec3& value, igtl::igtlUnit unit,
                  std::int64_t system_ns, std::vector<std::uint8_t>& out) {
  const auto sensor = igtl::SensorMessage::New();
  sensor->SetLength(3);
  sensor->SetUnit(unit);
  for (unsigned i = 0; i < 3; ++i) sensor->SetValue(i, value(i));
  Append(*sensor, name, system_ns, out);
}

igtl::igtlUnit NewtonTimes(int metres) {
  const auto unit = igtl::Unit::New();
  unit->Append(igtl::Unit::SI_DERIVED_NEWTON, 1);
  if (metres > 0) unit->Append(igtl::Unit::SI_BASE_METER, metres);
  return unit->Pack();
}

}  // namespace

std::string IgtlName(const std::string& station) {
  if (station.size() <= kNameLetters) return station;
  std::uint32_t hash = 2166136261u;  // FNV-1a
  for (const char c : station) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return station.substr(0, kNameBegin) + fmt::format("{:04x}", hash & 0xffff);
}

std::vector<std::uint8_t> IgtlMessages(const wire::ToolState& tool, std::int64_t system_ns) {
  std::vector<std::uint8_t> out;
  const Pose X_WG = wire::ToPose(tool.graphic_position_m, tool.graphic_orientation_wxyz);
  if (!X_WG.p.allFinite() || !X_WG.q.coeffs().allFinite() || !(X_WG.q.squaredNorm() > 0.25)) {
    return out;
  }
  const Eigen::Matrix3d C = SceneToRas();
  const Eigen::Matrix3d R = C * X_WG.q.normalized().toRotationMatrix();
  const Vec3 p_mm = 1e3 * C * X_WG.p;
  igtl::Matrix4x4 matrix;
  igtl::IdentityMatrix(matrix);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      matrix[row][column] = static_cast<float>(R(row, column));
    }
    matrix[row][3] = static_cast<float>(p_mm(row));
  }
  const std::string name = IgtlName(tool.station);
  const auto transform = igtl::TransformMessage::New();
  transform->SetMatrix(matrix);
  Append(*transform, name, system_ns, out);
  AppendSensor(name + "_force", C * wire::ToVec3(tool.force_N), NewtonTimes(0), system_ns, out);
  AppendSensor(name + "_torque", C * wire::ToVec3(tool.torque_Nm), NewtonTimes(1), system_ns, out);
  return out;
}

}  // namespace palpate
