#include "server/library/state_bytes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include "common/error.h"
#include "common/math/pose_check.h"
#include "common/revision.h"

namespace palpate {
namespace {

/// Then come the physics revision and zeros, the model's content, the state, and the
/// hash of all before.
constexpr std::string_view kMagic = "palpate-state-1\n";
constexpr std::size_t kRevisionSize = 16;

/// FNV-1a, 64 bits: each byte that differs makes another hash.
class Hash {
 public:
  void Add(const void* data, std::size_t size) {
    const auto* byte = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) hash_ = (hash_ ^ byte[i]) * 0x100000001b3u;
  }
  template <class T>
  void operator()(const T& number) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    Add(&number, sizeof number);
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

std::uint64_t HashOf(std::span<const std::uint8_t> bytes) {
  Hash hash;
  hash.Add(bytes.data(), bytes.size());
  return hash.value();
}

/// Types whose bytes are all theirs: no padding, no pointer, and every pattern is a value.
template <class T>
concept Plain = (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) ||
                std::is_same_v<T, SeparationFront::Pair> || std::is_same_v<T, PlaneRecord> ||
                std::is_same_v<T, SeparationFront::Eight> || std::is_same_v<T, EpochMotion> ||
                std::is_same_v<T, ContactId>;
static_assert(sizeof(SeparationFront::Pair) == 5 * sizeof(std::int32_t) &&
              sizeof(ContactId) == 4 * sizeof(std::int32_t) &&
              sizeof(PlaneRecord) == 8 * sizeof(double) &&
              sizeof(EpochMotion) == 12 * sizeof(double));

class Writer {
 public:
  void Put(const void* data, std::size_t size) {
    const auto* byte = static_cast<const std::uint8_t*>(data);
    bytes.insert(bytes.end(), byte, byte + size);
  }
  template <Plain T>
  void operator()(const T& value) {
    Put(&value, sizeof value);
  }
  void operator()(bool value) { (*this)(static_cast<std::uint8_t>(value)); }
  template <class Derived>
  void operator()(const Eigen::MatrixBase<Derived>& numbers) {
    const auto& m = numbers.derived();
    Put(m.data(), sizeof(double) * static_cast<std::size_t>(m.size()));
  }
  template <class T>
  void operator()(const std::vector<T>& values) {
    (*this)(static_cast<std::uint64_t>(values.size()));
    Put(values.data(), sizeof(T) * values.size());
  }
  std::vector<std::uint8_t> bytes;
};

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : rest_(bytes) {}
  void Take(void* data, std::size_t size) {
    if (size > rest_.size()) throw Error("state: ends too early; store it again");
    if (size > 0) std::memcpy(data, rest_.data(), size);
    rest_ = rest_.subspan(size);
  }
  template <Plain T>
  void operator()(T& value) {
    Take(&value, sizeof value);
  }
  void operator()(bool& value) {
    std::uint8_t byte = 0;
    (*this)(byte);
    value = byte != 0;
  }
  template <class Derived>
  void operator()(Eigen::MatrixBase<Derived>& numbers) {
    auto& m = numbers.derived();
    Take(m.data(), sizeof(double) * static_cast<std::size_t>(m.size()));
  }
  template <class T>
  void operator()(std::vector<T>& values) {
    std::uint64_t size = 0;
    (*this)(size);
    if (size > rest_.size() / sizeof(T)) throw Error("state: ends too early; store it again");
    values.resize(static_cast<std::size_t>(size));
    Take(values.data(), sizeof(T) * values.size());
  }
  std::size_t left() const { return rest_.size(); }

 private:
  std::span<const std::uint8_t> rest_;
};

template <class P, class Visit>
void ForEachMemberOfPose(P& pose, Visit& visit) {
  visit(pose.p);
  visit(pose.q.coeffs());
}

/// Visits all that a state is, without `felt` and `cut.fields`, which only solids need.
template <class State, class Visit>
void ForEachMember(State& all, Visit& visit) {
  auto& state = all.step;
  visit(all.start_depth);
  ForEachMemberOfPose(state.X_WG, visit);
  ForEachMemberOfPose(state.X_WH, visit);
  visit(state.active.count);
  for (int i = 0; i < std::clamp(state.active.count, 0, 7); ++i) {
    visit(state.active.id[std::size_t(i)]);
  }
  visit(state.behind.translation);
  visit(state.behind.rotation);
  visit(state.is_crowded);
  visit(state.rotation_G);
  for (auto& frame : state.frames) {  // as many as the model has
    ForEachMemberOfPose(frame.X_WB, visit);
    ForEachMemberOfPose(frame.X_WB_next, visit);
    SeparationFront::ForEachMember(frame.front, [&](auto&& member) { visit(member); });
  }
  visit(state.moved);
  auto& friction = state.friction;
  visit(friction.still);
  visit(friction.resets);
  visit(friction.suspended);
  visit(friction.contacts);
  for (int i = 0; i < std::clamp(friction.contacts, 0, 7); ++i) {
    const auto at = static_cast<std::size_t>(i);
    visit(friction.id[at]);
    visit(friction.normal_force[at]);
    visit(friction.force[at]);
  }
  visit(state.cut.spins);
  visit(state.cut.acts);
  visit(state.cut.drawn);
  visit(state.cut.drag);
  visit(state.cut.tooth);
  for (auto& memory : state.effects.of) {  // as many as the model has
    for (auto& number : memory.state) visit(number);
    bool is_off = memory.failure != nullptr;
    visit(is_off);
    if constexpr (!std::is_const_v<State>)
      memory.failure = is_off ? "it had failed before" : nullptr;
  }
  visit(state.effects.cycle);
  ForEachMemberOfPose(state.effects.X_WH, visit);
  visit(state.effects.V_WH.v);
  visit(state.effects.V_WH.w);
}

/// Steps of nine million years: more would overflow one day.
constexpr double kMostSteps = 0x1p58;

bool IsWithin(double value, double most) {
  return value >= 0.0 && value <= most;  // false for NaN
}

bool IsKnown(const HapticModel& model, const ContactId& id) {
  if (id.a < 0 || id.b < 0 || id.row < 0) return false;
  const auto tool = static_cast<std::size_t>(id.a), object = static_cast<std::size_t>(id.b);
  if (id.IsOfLeaves()) {
    return tool < model.tool().leaves.size() && object < model.objects().leaves.size();
  }
  if (id.body < 0 || static_cast<std::size_t>(id.body) >= model.bodies().size()) return false;
  return model.tool_body() != nullptr && tool < model.tool_body()->tree.triangles() &&
         object < model.bodies()[static_cast<std::size_t>(id.body)].shape->tree.triangles();
}

/// Returns whether a state can be stepped: everything that serves as an index, a count or a length
/// is one.  Forces depend on the other numbers as they do on those of any state.
bool IsSound(const HapticModel& model, const ProxyState& all) {
  const StepState& state = all.step;
  const FrictionState& friction = state.friction;
  const auto is_small = [](int number) {
    return number >= 0 && number <= FrictionState::kNeverSlipped;
  };
  const auto is_known = [&](const ContactId& id) { return IsKnown(model, id); };
  if (state.active.count < 0 || state.active.count > 7 || friction.contacts < 0 ||
      friction.contacts > 7) {
    return false;
  }
  const std::span used(friction.id.data(), static_cast<std::size_t>(friction.contacts));
  return IsPose(state.X_WG) && IsPose(state.X_WH) && IsWithin(all.start_depth, 1e3) &&
         std::ranges::all_of(std::span<const ContactId>(state.active), is_known) &&
         std::ranges::all_of(used, is_known) && IsWithin(state.behind.translation, 1.0) &&
         IsWithin(state.behind.rotation, 10.0) && state.rotation_G.allFinite() &&
         is_small(friction.still) && is_small(friction.resets) &&
         IsWithin(static_cast<double>(state.moved), kMostSteps) &&
         std::ranges::all_of(state.frames, [&](const BodyFrame& frame) {
           return IsPose(frame.X_WB) && IsPose(frame.X_WB_next) &&
                  frame.front.IsSound(*model.tool_body(), model.bodies());
         });
}

void RequireNoSolids(const HapticModel& model) {
  if (model.solids().empty()) return;
  throw Error(
      "state: of a scene with solids that burs cut it cannot be stored as bytes; copy it in the "
      "process");
}

std::array<char, kRevisionSize> RevisionText() {
  std::array<char, kRevisionSize> text{};
  std::string_view(kPhysicsRevision).copy(text.data(), text.size() - 1);
  return text;
}

void AddTriangles(const HullTree& tree, Hash& hash) {
  for (std::size_t t = 0; t < tree.triangles(); ++t) {
    const Mat3& corners = *tree.HullOf(~static_cast<HullTree::Node>(t)).leaf;
    hash.Add(corners.data(), sizeof(Mat3));
  }
}

}  // namespace

std::uint64_t ContentOf(const HapticModel& model) {
  Hash hash;
  const StepParameters& p = model.parameters();
  ForEachField(p, [&](const Tunable&, const auto& number) { hash(number); });
  for (const double number :
       {p.stiffness, p.torsional_stiffness, p.max_truncation, p.max_rotation, model.reference().x(),
        model.reference().y(), model.reference().z()}) {
    hash(number);
  }
  hash(p.max_rows);
  hash(p.features.contact);
  hash(p.features.friction);
  hash(p.features.compliance);
  hash(model.effects().Begin().of.size());
  hash(model.cutting() != nullptr);
  for (const auto* leaves : {&model.tool().leaves, &model.objects().leaves}) {
    for (const LeafSphere& leaf : *leaves) hash.Add(&leaf, sizeof leaf);
  }
  for (const Material& material : model.objects().materials) {
    for (const double number :
         {material.stiffness, material.static_friction, material.dynamic_friction}) {
      hash(number);
    }
  }
  const auto& kinds = model.objects().leaf_material;
  hash.Add(kinds.data(), sizeof kinds[0] * kinds.size());
  if (model.tool_body() != nullptr) {
    hash(model.tool_body()->radius);
    AddTriangles(model.tool_body()->tree, hash);
  }
  for (const MovedGroup& group : model.moved()) {
    hash.Add(group.point.data(), sizeof(Vec3));
    hash.Add(group.axis.data(), sizeof(Vec3));
    hash(group.smooth);
    hash(group.repeats);
    for (const MotionKey& key : group.keys) {
      hash(key.at);
      hash(key.turn);
      hash.Add(key.shift.data(), sizeof(Vec3));
    }
  }
  for (const ContactBody& body : model.bodies()) {
    hash.Add(body.X_BS.p.data(), sizeof(Vec3));
    hash.Add(body.X_BS.R.data(), sizeof(Mat3));
    hash(body.frame);
    AddTriangles(body.shape->tree, hash);
  }
  return hash.value();
}

std::vector<std::uint8_t> ToBytes(const HapticModel& model, const ProxyState& state) {
  RequireNoSolids(model);
  Writer writer;
  writer.Put(kMagic.data(), kMagic.size());
  writer.Put(RevisionText().data(), kRevisionSize);
  writer(ContentOf(model));
  ForEachMember(state, writer);
  writer(HashOf(writer.bytes));
  return std::move(writer.bytes);
}

ProxyState StateOf(const HapticModel& model, std::span<const std::uint8_t> bytes) {
  RequireNoSolids(model);
  Reader reader(bytes);
  std::array<char, kMagic.size()> magic{};
  std::array<char, kRevisionSize> revision{};
  std::uint64_t content = 0, hash = 0;
  if (bytes.size() >= magic.size()) reader.Take(magic.data(), magic.size());
  if (std::string_view(magic.data(), magic.size()) != kMagic) {
    throw Error("state: these bytes are no state of a proxy; give those that were stored");
  }
  reader.Take(revision.data(), revision.size());
  if (revision != RevisionText()) {
    revision.back() = '\0';
    throw Error("state: is of physics " + std::string(revision.data()) + ", this is physics " +
                kPhysicsRevision + "; load it with that build, or make it again");
  }
  reader(content);
  if (reader.left() < sizeof hash) throw Error("state: ends too early; store it again");
  Reader(bytes.last(sizeof hash))(hash);
  if (HashOf(bytes.first(bytes.size() - sizeof hash)) != hash) {
    throw Error("state: is damaged; store it again");
  }
  if (content != ContentOf(model)) {
    throw Error(
        "state: is of another model; give it to a proxy of the same tool, objects and parameters");
  }
  ProxyState state{StepState(model), 0.0};
  ForEachMember(state, reader);
  if (reader.left() != sizeof hash || !IsSound(model, state)) {
    throw Error("state: is damaged; store it again");
  }
  return state;
}

}  // namespace palpate
