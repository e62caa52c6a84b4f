#pragma once

#include <filesystem>
#include <vector>

#include "common/json/json_file.h"
#include "scenes/effects/effects.h"

namespace palpate {

/// Loads the effect that an entry of a scene file's "effects" names, and reads its parameters.  A
/// name with a slash, or that ends in .so, is a file: its path counts from the scene file's folder,
/// or from one of $PALPATE_EFFECTS.  Any other name is one of the effects that come with the
/// programs. Only code in a folder of $PALPATE_EFFECTS (AddEffectsOption adds to it) or of the
/// programs runs. Throws Error "file:line: field: ...".
Effect LoadEffect(const JsonNode& entry, const std::filesystem::path& folder);

/// Loads the effects that a bundle names, from the same folders.  Loads only files that have the
/// hash in the bundle.
/// @param folder  where the bundle lies: a file there is named in the message, and not run.
/// @param source  names the bundle in messages.
void LoadEffects(std::vector<Effect>& effects, const std::filesystem::path& folder,
                 const std::string& source);

}  // namespace palpate
