#include "tests/benchmarks/features.h"

#include "common/error.h"

namespace palpate::bench {

void FeatureOptions::AddTo(CLI::App& command) {
  command.add_option("--contact", contact, "spheres (the chapter's) or surface (the meshes)")
      ->check(CLI::IsMember({"spheres", "surface"}))
      ->capture_default_str();
  command.add_option("--friction", friction, "off, chapter (2.25-2.34) or coulomb")
      ->check(CLI::IsMember({"off", "chapter", "coulomb"}))
      ->capture_default_str();
}

Features FeatureOptions::features() const {
  if (friction != "off") {
    throw UsageError("this version has --friction off only");
  }
  Features features;
  features.contact = contact == "surface" ? ContactModel::kSurface : ContactModel::kSpheres;
  features.friction = friction == "coulomb"   ? FrictionModel::kCoulomb
                      : friction == "chapter" ? FrictionModel::kChapter
                                              : FrictionModel::kOff;
  return features;
}

}  // namespace palpate::bench
