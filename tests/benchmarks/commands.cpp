#include "tests/benchmarks/commands.h"

#include "scenes/files/scene_file.h"
#include "scenes/tree/sph_file.h"
#include "scenes/tree/tree_source.h"

namespace palpate::bench {
namespace {

template <class T>
bool IsNone(const T&) {
  return false;
}
template <class T>
bool IsNone(const std::optional<T>& value) {
  return !value;
}
template <class T>
bool IsNone(const std::vector<T>& values) {
  return values.empty();
}

}  // namespace

// Here alone, for what CLI11 makes of each type takes a compiler long.
template <class T>
CLI::Option* Add(CLI::App& command, const char* name, T& value, const std::string& help) {
  CLI::Option* option = command.add_option(name, value, help);
  if (!IsNone(value)) option->capture_default_str();
  if (option->get_items_expected_max() > 1) option->delimiter(',');
  return option;
}
template CLI::Option* Add(CLI::App&, const char*, std::string&, const std::string&);
template CLI::Option* Add(CLI::App&, const char*, int&, const std::string&);
template CLI::Option* Add(CLI::App&, const char*, long&, const std::string&);
template CLI::Option* Add(CLI::App&, const char*, std::uint64_t&, const std::string&);
template CLI::Option* Add(CLI::App&, const char*, double&, const std::string&);
template CLI::Option* Add(CLI::App&, const char*, std::optional<int>&, const std::string&);
template CLI::Option* Add(CLI::App&, const char*, std::optional<std::size_t>&, const std::string&);
template CLI::Option* Add(CLI::App&, const char*, std::vector<std::size_t>&, const std::string&);
template CLI::Option* Add(CLI::App&, const char*, std::vector<std::string>&, const std::string&);

void AddJson(CLI::App& command, std::string& file) {
  Add(command, "--json", file, "Write one JSON object to FILE (- is stdout)");
}

void AddModels(CLI::App& command, std::string& folder) {
  Add(command, "--models", folder, "Folder of models that are not packaged");
}

void AddPathSteps(CLI::App& command, std::optional<int>& steps) {
  Add(command, "--steps", steps, "Steps (default: the whole path)")->check(CLI::PositiveNumber);
}

void AddRepeats(CLI::App& command, int& repeats) {
  Add(command, "--repeats", repeats, "Identical runs; 'best' is the least of each step")
      ->check(CLI::PositiveNumber);
}

void AddTransport(CLI::App& command, std::string& transport) {
  Add(command, "--transport", transport, "shm or udp")->check(CLI::IsMember({"shm", "udp"}));
}

CLI::Option* AddTreeFile(CLI::App& command, const char* usual_unit, TreeSource& source) {
  source.where = "--tree";
  CLI::Option* file =
      Add(command, "--tree", source.file,
          "A tree of the Sphere-Tree Construction Toolkit of the same mesh "
          "(FILE.sph; none is supplied), to be measured beside those that are built");
  Add(command, "--level", source.level, "Level of that file, from 1; 0: its finest")
      ->check(CLI::Range(0, kMaxSphLevels))
      ->needs(file);
  return command
      .add_option_function<std::string>(
          "--unit",
          [&source](const std::string& unit) { source.metres_per_unit = MetresPerUnit(unit); },
          std::string("What a number in the file means (default: ") + usual_unit + ")")
      ->check(CLI::IsMember(std::vector<std::string>{kUnits.begin(), kUnits.end()}));
}

}  // namespace palpate::bench
