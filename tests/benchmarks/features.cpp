#include "tests/benchmarks/features.h"

namespace palpate::bench {

void AddFeatureOptions(CLI::App& command, FeatureOverrides& features,
                       const std::string& otherwise) {
  const std::string tail = " (default: " + otherwise + ")";
  command
      .add_option("--contact", features.contact,
                  "spheres (the chapter's) or surface (the meshes)" + tail)
      ->check(CLI::IsMember({"spheres", "surface"}));
  command.add_option("--friction", features.friction, "off, chapter (2.25-2.34) or coulomb" + tail)
      ->check(CLI::IsMember({"off", "chapter", "coulomb"}));
}

}  // namespace palpate::bench
