#pragma once

#include "common/dds/wire.h"
#include "idl/progress.h"

namespace palpate::wire {

using SceneProgress = palpate_SceneProgress;

template <>
inline const dds_topic_descriptor_t& Descriptor<SceneProgress>() {
  return palpate_SceneProgress_desc;
}

}  // namespace palpate::wire

namespace palpate::dds {

inline constexpr const char* kSceneProgressTopic = "palpate/scene_progress";

}  // namespace palpate::dds
