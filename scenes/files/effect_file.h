#pragma once

#include <filesystem>
#include <vector>

#include "common/json/json_file.h"
#include "scenes/effects/effects.h"

namespace palpate {

/// Loads the effect that an entry of a scene file's "effects" names, and reads its parameters.  A
/// name with a slash, or that ends in .so, is a file: it is looked for in the scene file's folder,
/// then among the effects that come with the programs.  Any other name is one of the latter.
/// Throws Error "file:line: field: ...".
/// The file contains code, which is run: trust a scene file only as much as a program.
Effect LoadEffect(const JsonNode& entry, const std::filesystem::path& folder);

/// Loads the effects that a bundle names: from `folder`, from the folders in $PALPATE_EFFECTS, or
/// from those that come with the programs.  Loads only files that have the hash in the bundle.
/// @param source  names the bundle in messages.
void LoadEffects(std::vector<Effect>& effects, const std::filesystem::path& folder,
                 const std::string& source);

}  // namespace palpate
