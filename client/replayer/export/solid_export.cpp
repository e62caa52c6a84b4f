#include "client/replayer/export/solid_export.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "client/replayer/export/export_folder.h"
#include "client/replayer/export/methods.h"
#include "client/replayer/verify/verify.h"
#include "common/error.h"
#include "common/files/output.h"
#include "common/text/quoted.h"
#include "scenes/files/scene_bundle.h"
#include "scenes/grid/solid_surface.h"
#include "scenes/mesh/mesh_export.h"
#include "scenes/tree/sphere_tree_builder.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kPlain = 0xe6dfd0;  // for a material without colour
constexpr double kMillimetre = 1e-3;

std::vector<std::uint32_t> ColoursOf(const SolidSurface& surface,
                                     const std::vector<Material>& materials) {
  std::vector<std::uint32_t> colours;
  for (const std::uint8_t material : surface.materials) {
    const std::uint32_t colour = materials[material].colour;
    colours.push_back(colour == Material::kNoColour ? kPlain : colour);
  }
  return colours;
}

/// Writes the files one by one, and checks for Ctrl-C before each.
class Files {
 public:
  Files(fs::path folder, const std::string& name, const StopSignal& stop)
      : folder_(std::move(folder)), name_(name), stop_(stop) {}

  void Write(const fs::path& file, const std::string& bytes) {
    if (stop_.stopped()) {
      throw Error(name_ + ": stopped before it was complete; the partial result was removed");
    }
    fs::create_directories((folder_ / file).parent_path());
    WriteOutput("-o", folder_ / file, bytes);
    files_.push_back(file.string());
  }
  const std::vector<std::string>& files() const { return files_; }

 private:
  const fs::path folder_;
  const std::string& name_;
  const StopSignal& stop_;
  std::vector<std::string> files_;
};

void WriteSolids(const SolidsCut& left, const fs::path& folder, Files& files) {
  Scene scene = *left.scene;
  for (std::size_t s = 0; s < left.after.size(); ++s) {
    Body& body = scene.objects[left.objects->solids[s].object];
    SolidSurface surface = WholeSurface(left.after[s]);
    if (surface.triangles.empty()) continue;  // nothing of it is left
    body.mesh = {std::move(surface.vertices), std::move(surface.triangles)};
    const MeshExportOptions options{.metres_per_unit = kMillimetre,
                                    .comment = "what is left, in mm",
                                    .colours = ColoursOf(surface, body.materials)};
    for (const char* const ending : {".stl", ".ply"}) {
      const std::string file = body.name + ending;
      files.Write(folder / file, ExportMesh(body.mesh, file, options));
    }
    body.tree = BuildInnerTree(body.mesh);
    body.leaf_material.clear();
    body.ambient.clear();
  }
  const std::vector<std::uint8_t> bytes = PackScene(scene);
  files.Write(folder / (scene.name + ".palpate"), std::string(bytes.begin(), bytes.end()));
}

Verification Recompute(const SolidExportOptions& options, const StopSignal& stop) {
  VerifyOptions verify;
  verify.models_dir = options.models_dir;
  verify.keep_left = true;
  verify.until_s = options.at_s;
  verify.stop = &stop;
  Verification verification = Verify(options.files, verify);
  for (const SessionVerdict& session : verification.sessions) {
    if (session.good() || session.recorded == 0) continue;
    throw Error(options.files.front() + ": what station '" + session.station +
                "' cut cannot be computed again: " +
                (session.ends.empty() ? "this version gives other forces than were recorded; "
                                        "export it with the version that recorded it"
                                      : session.ends));
  }
  if (verification.left.empty()) {
    throw Error(options.files.front() + ": no hand with a bur has come" +
                (std::isinf(options.at_s)
                     ? std::string("; without --solids its columns are written")
                     : fmt::format(" by {:g} s; give a later --at", options.at_s)));
  }
  return verification;
}

}  // namespace

void ExportSolids(const SolidExportOptions& options, StopSignal& stop) {
  ExportFolder folder(options.folder);
  const Verification verification = Recompute(options, stop);
  Files files(folder.path(), options.folder, stop);
  for (std::size_t i = 0; i < verification.left.size(); ++i) {
    const SolidsCut& left = verification.left[i];
    const bool is_one_of_several = verification.left.size() > 1;
    WriteSolids(left, is_one_of_several ? fmt::format("{}-{}", left.scene->name, i + 1) : "",
                files);
  }
  nlohmann::ordered_json methods{{"made_by", kExportMaker}, {"recording", options.files}};
  if (std::isfinite(options.at_s)) methods["at_s"] = options.at_s;
  methods["files"] = files.files();
  WriteOutput("-o", folder.path() / "methods.json",
              methods.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  folder.Finish();
  std::printf("%s:", Printable(options.folder).c_str());
  for (const std::string& file : files.files()) std::printf(" %s", Printable(file).c_str());
  std::printf("\n");
}

}  // namespace palpate
