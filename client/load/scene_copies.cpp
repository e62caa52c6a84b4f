#include "client/load/scene_copies.h"

#include <filesystem>
#include <fstream>

#include <nlohmann/json.hpp>

#include "common/error.h"
#include "common/files/whole_file.h"
#include "common/json/json_file.h"
#include "scenes/catalogue.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Mesh paths are relative to the scene's folder, and the copy is in another folder.
void MakeMeshPathsAbsolute(Json& bodies, const fs::path& folder) {
  for (Json& body : bodies) {
    if (!body["mesh"].contains("file")) continue;
    const fs::path mesh = body["mesh"]["file"].get<std::string>();
    body["mesh"]["file"] = fs::absolute(folder / mesh).lexically_normal().string();
  }
}

}  // namespace

void WriteSceneWithCopies(const std::string& scene, std::size_t copies, const std::string& file) {
  LoadScene(scene);  // throws better error messages than the code below
  const std::string from = FindSceneFile(scene);
  Json json = Json::parse(ReadWholeFile(from, JsonNode::kMostBytes), nullptr, false, true);
  if (json.is_discarded()) {
    throw Error(from + ": is not a scene file; give --scene a name or a .json file");
  }
  const fs::path folder = fs::path(from).parent_path();
  MakeMeshPathsAbsolute(json["tools"], folder);
  MakeMeshPathsAbsolute(json["objects"], folder);
  if (json.contains("effects")) {
    for (Json& effect : json["effects"]) {
      const std::string name = effect["name"].get<std::string>();
      if (fs::exists(folder / name)) effect["name"] = fs::absolute(folder / name).string();
    }
  }
  const Json tool = json["tools"][0];
  json["tools"] = Json::array();
  for (std::size_t i = 1; i <= copies; ++i) {
    Json copy = tool;
    copy["name"] = tool["name"].get<std::string>() + "_" + std::to_string(i);
    json["tools"].push_back(std::move(copy));
  }
  std::ofstream out(file);
  if (!(out << json.dump(2) << '\n') || !out.flush()) {
    throw Error("--make-scene: " + file +
                " cannot be written; give a file in a folder that exists");
  }
  const std::string script = ScriptFileBeside(scene);
  std::error_code error;
  if (!fs::exists(script)) return;
  fs::copy_file(script, ScriptFileBeside(file), fs::copy_options::overwrite_existing, error);
  if (error) throw Error(ScriptFileBeside(file) + ": " + error.message());
}

}  // namespace palpate
