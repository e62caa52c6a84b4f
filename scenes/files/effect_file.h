#pragma once

#include <filesystem>
#include <vector>

#include "common/json/json_file.h"
#include "scenes/effects/effects.h"

namespace palpate {

/// Loads the effect that an entry of a scene file's "effects" names, and reads its parameters.  A
/// name with a slash or that ends in .so is a file: looked for in the scene file's folder, then
/// among the effects that come with the programs, where any other name is.  Throws Error
/// "file:line: field: ...".
/// The file is code that is run: a scene file is as much to be trusted as a program.
Effect LoadEffect(const JsonNode& entry, const std::filesystem::path& folder);

/// The same for effects that a bundle names: looked for in `folder`, in those that
/// $PALPATE_EFFECTS names, then among those that come with the programs.  Only what has the
/// bundle's hash is loaded.
/// @param source  names the bundle in messages.
void LoadEffects(std::vector<Effect>& effects, const std::filesystem::path& folder,
                 const std::string& source);

}  // namespace palpate
