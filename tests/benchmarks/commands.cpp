#include "tests/benchmarks/commands.h"

#include <CLI/CLI.hpp>

#include "scenes/files/scene_file.h"
#include "scenes/tree/sph_file.h"
#include "scenes/tree/tree_source.h"

namespace palpate::bench {

CommandOption& CommandOption::Positive() {
  option_.check(CLI::PositiveNumber);
  return *this;
}

CommandOption& CommandOption::NonNegative() {
  option_.check(CLI::NonNegativeNumber);
  return *this;
}

template <class T>
CommandOption& CommandOption::Within(T least, T most) {
  option_.check(CLI::Range(least, most));
  return *this;
}
template CommandOption& CommandOption::Within(int, int);
template CommandOption& CommandOption::Within(double, double);
template CommandOption& CommandOption::Within(std::size_t, std::size_t);

CommandOption& CommandOption::OneOf(std::vector<std::string> values) {
  option_.check(CLI::IsMember(std::move(values)));
  return *this;
}

CommandOption& CommandOption::ExistingFolder() {
  option_.check(CLI::ExistingDirectory);
  return *this;
}

CommandOption& CommandOption::Required() {
  option_.required();
  return *this;
}

CommandOption& CommandOption::Needs(const char* other) {
  option_.needs(command_.get_option(other));
  return *this;
}

CommandOption& CommandOption::Excludes(const char* other) {
  option_.excludes(command_.get_option(other));
  return *this;
}

Command::Command(CLI::App& app, const std::string& name, const std::string& what)
    : app_(*app.add_subcommand(name, what)) {}

void Command::Runs(std::function<void()> run) {
  app_.callback(std::move(run));
}

void Command::Hide() {
  app_.group("");
}

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

template <class T>
CommandOption Command::Add(const char* name, T& value, const std::string& help) {
  CLI::Option& option = *app_.add_option(name, value, help);
  if (!IsNone(value)) option.capture_default_str();
  if (option.get_items_expected_max() > 1) option.delimiter(',');
  return {app_, option};
}
template CommandOption Command::Add(const char*, std::string&, const std::string&);
template CommandOption Command::Add(const char*, int&, const std::string&);
template CommandOption Command::Add(const char*, long&, const std::string&);
template CommandOption Command::Add(const char*, std::uint64_t&, const std::string&);
template CommandOption Command::Add(const char*, double&, const std::string&);
template CommandOption Command::Add(const char*, std::optional<int>&, const std::string&);
template CommandOption Command::Add(const char*, std::optional<std::size_t>&, const std::string&);
template CommandOption Command::Add(const char*, std::vector<std::size_t>&, const std::string&);
template CommandOption Command::Add(const char*, std::vector<std::string>&, const std::string&);

CommandOption Command::AddFunction(const char* name, std::function<void(const std::string&)> set,
                                   const std::string& help) {
  return {app_, *app_.add_option_function<std::string>(name, std::move(set), help)};
}

void Command::AddFlag(const char* name, bool& value, const std::string& help) {
  app_.add_flag(name, value, help);
}

void Command::AddJson(std::string& file) {
  Add("--json", file, "Write one JSON object to FILE (- is stdout)");
}

void Command::AddModels(std::string& folder) {
  Add("--models", folder, "Folder of models that are not packaged");
}

void Command::AddPathSteps(std::optional<int>& steps) {
  Add("--steps", steps, "Steps (default: the whole path)").Positive();
}

void Command::AddRepeats(int& repeats) {
  Add("--repeats", repeats, "Identical runs; 'best' is the least of each step").Positive();
}

void Command::AddTransport(std::string& transport) {
  Add("--transport", transport, "shm or udp").OneOf({"shm", "udp"});
}

CommandOption Command::AddTreeFile(const char* usual_unit, TreeSource& source) {
  source.where = "--tree";
  Add("--tree", source.file,
      "A tree of the Sphere-Tree Construction Toolkit of the same mesh (FILE.sph; none is "
      "supplied), "
      "to be measured beside those that are built");
  Add("--level", source.level, "Level of that file, from 1; 0: its finest")
      .Within(0, kMaxSphLevels)
      .Needs("--tree");
  return AddFunction(
             "--unit",
             [&source](const std::string& unit) { source.metres_per_unit = MetresPerUnit(unit); },
             std::string("What a number in the file means (default: ") + usual_unit + ")")
      .OneOf({kUnits.begin(), kUnits.end()});
}

}  // namespace palpate::bench
