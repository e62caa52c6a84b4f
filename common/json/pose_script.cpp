#include "common/json/pose_script.h"

#include <algorithm>
#include <utility>

#include "common/error.h"
#include "common/files/whole_file.h"
#include "common/json/json_file.h"
#include "common/math/rotation.h"

namespace palpate {

PoseScript PoseScript::Load(const std::string& file) {
  return Parse(ReadWholeFile(file, JsonNode::kMostBytes), file);
}

PoseScript PoseScript::Parse(std::string_view text, const std::string& file) {
  const JsonNode root = JsonNode::Parse(text, file);
  root.AllowOnly({"description", "keys"});
  std::vector<Key> keys;
  for (const JsonNode& item : root.At("keys").Items(1)) {
    item.AllowOnly({"t", "position_mm", "rotation_deg", "quaternion_wxyz", "label"});
    const JsonNode time = item.At("t");
    Key key;
    key.t = time.Number(0.0);
    if (keys.empty() && key.t != 0.0) time.Fail("the first key must be at 0; set it to 0");
    if (!keys.empty() && !(key.t > keys.back().t)) {
      time.Fail("is not after the key before; give keys in the order of their times");
    }
    key.X_WH = item.ReadPose();
    // A key without position or rotation keeps that of the previous key.
    if (!keys.empty() && !item.Has("position_mm")) key.X_WH.p = keys.back().X_WH.p;
    if (!keys.empty() && !item.Has("rotation_deg") && !item.Has("quaternion_wxyz")) {
      key.X_WH.q = keys.back().X_WH.q;
    }
    if (auto label = item.Find("label")) {
      key.label = label->String();
    } else if (!keys.empty()) {
      key.label = keys.back().label;
    }
    keys.push_back(std::move(key));
  }
  return PoseScript(std::move(keys));
}

PoseScript::PoseScript(std::vector<Key> keys) : keys_(std::move(keys)) {
  if (keys_.empty() || keys_.front().t != 0.0) {
    throw Error("pose script: the first key must be at t = 0; add one");
  }
  for (std::size_t i = 1; i < keys_.size(); ++i) {
    if (!(keys_[i].t > keys_[i - 1].t)) {
      throw Error("pose script: keys[" + std::to_string(i) +
                  "].t is not after the key before; give keys in the order of their times");
    }
  }
}

Pose PoseScript::At(double t) const noexcept {
  if (!(t > 0.0)) return keys_.front().X_WH;
  if (t >= keys_.back().t) return keys_.back().X_WH;
  const auto next = std::upper_bound(keys_.begin(), keys_.end(), t,
                                     [](double time, const Key& key) { return time < key.t; });
  const Key& a = *(next - 1);
  const Key& b = *next;
  const double u = (t - a.t) / (b.t - a.t);
  const double s = u * u * u * (10.0 + u * (6.0 * u - 15.0));
  const Vec3 turn = RotationLog(b.X_WH.q * a.X_WH.q.conjugate());
  return {a.X_WH.p + s * (b.X_WH.p - a.X_WH.p), RotationExp(s * turn) * a.X_WH.q};
}

const std::string& PoseScript::LabelAt(double t) const noexcept {
  const auto next = std::upper_bound(keys_.begin() + 1, keys_.end(), t,
                                     [](double time, const Key& key) { return time < key.t; });
  return (next - 1)->label;
}

}  // namespace palpate
