#include "scenes/files/effect_file.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <mutex>
#include <sstream>
#include <string_view>

#include "common/error.h"
#include "common/files/project_files.h"
#include "common/files/shared_library.h"
#include "common/files/whole_file.h"
#include "common/text/hex16.h"
#include "common/text/quoted.h"
#include "scenes/files/scene_bundle.h"
#include "scenes/files/scene_file.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostPoints = 1000;  // which each step may walk
constexpr std::uint64_t kLargestEffect = std::uint64_t{64} << 20;

struct Symbols {
  const palpate_effect* effect = nullptr;

  template <class Visit>
  void ForEach(Visit visit) {
    visit(effect, "palpate_the_effect");
  }
};

fs::path ShippedFolder() {
  const fs::path programs = ProgramFolder(), beside = programs / "effects";
  std::error_code ignored;
  return fs::exists(beside, ignored) ? beside
                                     : (programs / "../lib/palpate/effects").lexically_normal();
}

bool Exists(const fs::path& file) {
  std::error_code ignored;
  return fs::exists(file, ignored);
}

std::uint64_t HashOf(const fs::path& file) {
  return HashBytes(ReadWholeFile(file.string(), kLargestEffect), 0);
}

/// Throws Error for a file that has changed since it was loaded: the loader would return
/// the old one.
void RefuseWhatHasChanged(const fs::path& file, std::uint64_t hash, const std::string& who) {
  static std::mutex mutex;
  static std::map<std::string, std::uint64_t> loaded;
  const std::lock_guard lock(mutex);
  if (loaded.try_emplace(fs::canonical(file).string(), hash).first->second == hash) return;
  throw Error(who + ": " + file.string() +
              " has changed since this program loaded it; restart the program");
}

/// @param who  the beginning of messages.
void Load(const fs::path& file, const std::string& who, Effect& effect) {
  effect.file = file.filename().string();
  const bool is_name =
      effect.file.size() <= kLongestName && std::ranges::all_of(effect.file, IsOfName);
  if (!is_name) {
    throw Error(who + ": " + effect.file +
                " is not a valid file name of an effect; use letters, digits, - _ and .");
  }
  // Without a slash the loader would search other folders.
  const fs::path full = fs::absolute(file);
  effect.of =
      SharedLibrary<Symbols>::Load(
          {full.string()}, {.who = who,
                            .library = "effect",
                            .install = "build it as a shared object (scenes/effects/README.md)",
                            .files = {},
                            .not_it = "define that, as palpate_effect.h declares it"})
          .functions.effect;
  effect.hash = HashOf(full);
  RefuseWhatHasChanged(full, effect.hash, who);
  CheckAbi(effect.of->abi, PALPATE_EFFECT_ABI, who, full.string() + ": palpate_the_effect.abi",
           "palpate_effect.h");
  if (effect.of->step != nullptr) return;
  throw Error(who + ": " + full.string() + ": palpate_the_effect.step is NULL; give the function");
}

/// Returns the folders whose code may run: those that the user names, and that of the programs.
/// What lies beside a scene, a bundle or a recording came with it, perhaps from a stranger.
std::vector<fs::path> TrustedFolders() {
  std::vector<fs::path> folders;
  const char* named = std::getenv("PALPATE_EFFECTS");
  std::istringstream path(named ? named : "");
  for (std::string folder; std::getline(path, folder, ':');) {
    if (!folder.empty()) folders.emplace_back(folder);  // an empty one would be that of the shell
  }
  folders.push_back(ShippedFolder());
  return folders;
}

/// Returns whether the file lies in one of these folders itself, however its path is spelt.  A link
/// in a trusted folder is as trusted as the folder; one that lies elsewhere is not.
bool IsIn(const fs::path& file, const std::vector<fs::path>& folders) {
  const fs::path its = fs::absolute(file).parent_path();
  return std::ranges::any_of(folders, [&](const fs::path& folder) {
    std::error_code none;
    return fs::equivalent(its, folder, none);
  });
}

std::string Untrusted(const fs::path& file) {
  return file.string() + " is code, and is not run, because nobody has named its folder; if you " +
         "trust it, give --effects " + ShellWord(fs::absolute(file).parent_path().string()) +
         ", or that folder in PALPATE_EFFECTS";
}

/// Returns the path of an effect from its name in a scene file.
fs::path Find(const JsonNode& entry, const fs::path& folder) {
  const JsonNode node = entry.At("name");
  const std::string name = node.String();
  const fs::path shipped = ShippedFolder();
  const std::vector<fs::path> trusted = TrustedFolders();
  std::vector<fs::path> places{shipped / (name + ".so")};
  if (name.find('/') != std::string::npos || name.ends_with(".so")) {
    places = {folder / name};
    for (const fs::path& other : trusted) places.push_back(other / name);
  }
  std::string looked, names;
  fs::path refused;
  for (const fs::path& file : places) {
    looked += " " + file.string();
    if (!Exists(file)) continue;
    if (IsIn(file, trusted)) return file;
    if (refused.empty()) refused = file;
  }
  if (!refused.empty()) node.Fail(Untrusted(refused));
  std::error_code ignored;
  for (const auto& other : fs::directory_iterator(shipped, ignored)) {
    names += " " + other.path().stem().string();
  }
  const std::string there = names.empty() ? "none are in that folder (install palpate-common, or "
                                            "let PALPATE_PROGRAMS name the programs' folder)"
                                          : "there are" + names;
  node.Fail("there is no effect \"" + name + "\", looked for as" + looked + "; " + there +
            ", and the file of one of your own has a / or ends in .so, and counts from the scene "
            "file or from --effects DIR (scenes/effects/README.md)");
}

std::vector<double> Read(const JsonNode& node, const palpate_effect_parameter& parameter) {
  if (parameter.kind == PALPATE_EFFECT_NUMBER)
    return {node.Number(parameter.least, parameter.most)};
  std::vector<double> numbers;
  const auto read = [&](const JsonNode& point) {
    const std::vector<JsonNode> xyz = point.Items();
    if (xyz.size() != 3) point.Fail("is no point; give [x, y, z]");
    for (const JsonNode& number : xyz)
      numbers.push_back(number.Number(parameter.least, parameter.most));
  };
  if (parameter.kind == PALPATE_EFFECT_POINT) {
    read(node);
    return numbers;
  }
  for (const JsonNode& point : node.Items(2, kMostPoints)) read(point);
  return numbers;
}

}  // namespace

Effect LoadEffect(const JsonNode& entry, const fs::path& folder) {
  Effect effect;
  Load(Find(entry, folder), entry.At("name").Where(), effect);
  const auto parameters = ParametersOf(*effect.of);
  std::vector<std::string_view> fields{"name"};
  for (const palpate_effect_parameter& parameter : parameters) fields.push_back(parameter.name);
  entry.AllowOnly(fields);
  for (const palpate_effect_parameter& parameter : parameters) {
    const bool may_lack = !std::isnan(parameter.usual) && parameter.kind != PALPATE_EFFECT_POINTS;
    if (may_lack && !entry.Has(parameter.name)) {
      effect.values.emplace_back(parameter.kind == PALPATE_EFFECT_POINT ? 3 : 1, parameter.usual);
    } else {
      effect.values.push_back(Read(entry.At(parameter.name), parameter));
    }
  }
  return effect;
}

void LoadEffects(std::vector<Effect>& effects, const fs::path& folder, const std::string& source) {
  const std::vector<fs::path> trusted = TrustedFolders();
  for (Effect& effect : effects) {
    const std::uint64_t hash = effect.hash;
    std::string found;
    for (const fs::path& other : trusted) {
      const fs::path file = other / effect.file;
      if (effect.of != nullptr || !Exists(file)) continue;
      const std::uint64_t its = HashOf(file);
      found += "; " + file.string() + " is another one (hash " + Hex16(its) + ")";
      if (its == hash) Load(file, source + ": effect " + effect.file, effect);
    }
    if (effect.of != nullptr) continue;
    const fs::path beside = folder / effect.file;
    if (Exists(beside) && !IsIn(beside, trusted)) found += "; " + Untrusted(beside);
    throw Error(source + ": was made with an effect " + effect.file + " of the hash " +
                Hex16(hash) + ", which was not found" + found +
                "; give the folder of that file by --effects or in PALPATE_EFFECTS");
  }
}

}  // namespace palpate
