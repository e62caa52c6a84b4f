#include "common/recording/recorded_type.h"

#include <array>

#include "common/recording/idl_texts.h"

namespace palpate {
namespace {

struct Entry {
  const char* name;
  const std::string* text;
};

const Entry& EntryOf(RecordedType type) {
  static const std::string haptics = kHapticsIdl, offer = kOfferIdl, session = kSessionIdl,
                           solid = kSolidIdl, teaching = kTeachingIdl;
  static const std::array<Entry, kRecordedTypes> entries = {{
      {"palpate::HapticPose", &haptics},
      {"palpate::Wrench", &haptics},
      {"palpate::SessionRequest", &session},
      {"palpate::SessionState", &session},
      {"palpate::LoopWhole", &session},
      {"palpate::ToolState", &teaching},
      {"palpate::LoopStatistics", &teaching},
      {"palpate::SceneBundle", &teaching},
      {"palpate::GuideTarget", &teaching},
      {"palpate::StationStatistics", &teaching},
      {"palpate::SceneOffer", &offer},
      {"palpate::WholeRequest", &session},
      {"palpate::SceneWhole", &session},
      {"palpate::SolidBlock", &solid},
      {"palpate::CutLog", &solid},
      {"palpate::MovedState", &teaching},
  }};
  return entries[static_cast<std::size_t>(type)];
}

}  // namespace

const char* SchemaName(RecordedType type) {
  return EntryOf(type).name;
}

const std::string& SchemaText(RecordedType type) {
  return *EntryOf(type).text;
}

std::optional<RecordedType> TypeOfSchema(const std::string& schema_name) {
  for (int i = 0; i < kRecordedTypes; ++i) {
    const auto type = static_cast<RecordedType>(i);
    if (schema_name == SchemaName(type)) return type;
  }
  return std::nullopt;
}

void SequenceCount::Add(std::uint64_t sequence) {
  if (!any_) {
    any_ = true;
    first_ = last_ = sequence;
    return;
  }
  if (std::max(sequence, last_) - std::min(sequence, last_) > kMostHole) {
    ++astray_;
    return;
  }
  // A repeated sample, as after a split, is not a gap.
  if (sequence <= last_) return;
  if (sequence > last_ + 1) {
    ++holes_;
    missing_ += sequence - last_ - 1;
  }
  last_ = sequence;
}

}  // namespace palpate
