#include "common/program/command_line.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <new>
#include <sstream>
#include <string_view>

#include <CLI/CLI.hpp>
#include <sched.h>

#include "common/dds/topics.h"
#include "common/error.h"
#include "common/http/host_name.h"
#include "common/revision.h"
#include "common/text/joined.h"
#include "common/text/lower_case.h"
#include "common/text/nearest_word.h"
#include "common/text/wrapped.h"

namespace palpate {
namespace {

constexpr int kHelpColumns = 80;

/// Wraps the descriptions of options and commands, which CLI11 leaves to the terminal.
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option_desc(const CLI::Option* option) const override {
    return InItsColumn(CLI::Formatter::make_option_desc(option));
  }

  std::string make_subcommand(const CLI::App* command) const override {
    const std::string about = command->get_description();
    std::ostringstream out;
    CLI::detail::format_help(out, command->get_name(),
                             InItsColumn(about.substr(0, about.find('\n'))), get_column_width());
    return out.str();
  }

 private:
  std::string InItsColumn(const std::string& text) const {
    return Joined(Wrapped(text, kHelpColumns - static_cast<int>(get_column_width())),
                  std::identity{}, "\n");
  }
};

/// Makes all numeric options reject NaN and infinity: comparisons, and so CLI11's ranges,
/// accept NaN.
void MakeNumbersFinite(CLI::App& app) {
  const CLI::Validator finite(
      [](std::string& text) {
        return std::isfinite(std::strtod(text.c_str(), nullptr)) ? "" : "give a finite number";
      },
      "");
  for (CLI::Option* option : app.get_options()) {
    if (option->get_type_name().starts_with("FLOAT")) option->check(finite);
  }
}

/// Returns the options or commands of these apps, spelled as on the command line.
std::vector<std::string> WordsOf(const std::vector<const CLI::App*>& apps, bool options) {
  std::vector<std::string> words;
  for (const CLI::App* app : apps) {
    if (options) {
      for (const CLI::Option* option : app->get_options()) {
        for (const std::string& name : option->get_lnames()) words.push_back("--" + name);
      }
    } else {
      const auto all = [](const CLI::App*) { return true; };
      for (const CLI::App* command : app->get_subcommands(all))
        words.push_back(command->get_name());
    }
  }
  return words;
}

/// Describes the first word that no option or command accepts, options first, with the likely
/// intended one; empty if there is none.
std::string UnknownWord(const CLI::App& app) {
  const std::vector<std::string> unknown = app.remaining(true);
  if (unknown.empty()) return "";
  const auto is_option = [](const std::string& word) { return word.starts_with("-"); };
  const auto option = std::ranges::find_if(unknown, is_option);
  const std::string word = option != unknown.end() ? *option : unknown.front();
  std::vector<const CLI::App*> apps{&app};
  const auto given = [](const CLI::App* command) { return command->parsed(); };
  for (const CLI::App* command : app.get_subcommands(given)) apps.push_back(command);
  const std::vector<std::string> words = WordsOf(apps, option != unknown.end());
  const std::string_view guess =
      NearestWord(word.substr(0, word.find('=')), {words.begin(), words.end()});
  std::string text = "'" + word + "' is not known";
  if (!guess.empty()) text.append("; did you mean '").append(guess).append("'?");
  return text;
}

}  // namespace

bool Option::given() const {
  return option_->count() > 0;
}

Option Option::Required() const {
  return Option(option_->required());
}

Option Option::ShowDefault() const {
  return Option(option_->capture_default_str());
}

Option Option::ShowDefault(const std::string& text) const {
  return Option(option_->default_str(text));
}

Option Option::TypeName(const std::string& name) const {
  return Option(option_->type_name(name));
}

Option Option::Needs(Option other) const {
  return Option(option_->needs(other.option_));
}

Option Option::Excludes(Option other) const {
  return Option(option_->excludes(other.option_));
}

Option Option::Range(int least, int most) const {
  return Option(option_->check(CLI::Range(least, most)));
}

Option Option::Range(double least, double most) const {
  return Option(option_->check(CLI::Range(least, most)));
}

Option Option::Range(std::size_t least, std::size_t most) const {
  return Option(option_->check(CLI::Range(least, most)));
}

Option Option::Positive() const {
  return Option(option_->check(CLI::PositiveNumber));
}

Option Option::NotNegative() const {
  return Option(option_->check(CLI::NonNegativeNumber));
}

Option Option::OneOf(const std::vector<std::string>& words) const {
  return Option(option_->check(CLI::IsMember(words)));
}

Option Option::ExistingFolder() const {
  return Option(option_->check(CLI::ExistingDirectory));
}

Option Option::Check(const std::function<std::string(const std::string&)>& complaint) const {
  return Option(option_->check(complaint));
}

Option Option::Transform(const std::function<std::string(std::string)>& transform) const {
  return Option(option_->transform(transform));
}

Option Option::Words(int count) const {
  return Option(option_->expected(count));
}

Option Option::OneAtATime() const {
  return Option(option_->allow_extra_args(false));
}

Option Option::Commas() const {
  return Option(option_->delimiter(','));
}

CommandLine::CommandLine(const std::string& about, const std::string& program,
                         const std::string& examples)
    : app_(std::make_shared<CLI::App>(about, program)) {
  app_->formatter(std::make_shared<HelpFormatter>());  // its commands inherit it
  Footer(examples);
}

CommandLine::CommandLine(std::shared_ptr<CLI::App> app) : app_(std::move(app)) {}

const std::string& CommandLine::name() const {
  return app_->get_name();
}

bool CommandLine::given() const {
  return app_->parsed();
}

template <class T>
Option CommandLine::Add(const std::string& name, T& value, const std::string& help) const {
  return Option(app_->add_option(name, value, help));
}
#define PALPATE_OPTION_OF(...) \
  template Option CommandLine::Add(const std::string&, __VA_ARGS__&, const std::string&) const;
PALPATE_OPTION_OF(std::string)
PALPATE_OPTION_OF(int)
PALPATE_OPTION_OF(long)
PALPATE_OPTION_OF(std::size_t)
PALPATE_OPTION_OF(double)
PALPATE_OPTION_OF(std::optional<int>)
PALPATE_OPTION_OF(std::optional<std::size_t>)
PALPATE_OPTION_OF(std::optional<double>)
PALPATE_OPTION_OF(std::optional<std::string>)
PALPATE_OPTION_OF(std::vector<int>)
PALPATE_OPTION_OF(std::vector<std::size_t>)
PALPATE_OPTION_OF(std::vector<std::string>)
#undef PALPATE_OPTION_OF

Option CommandLine::AddText(const std::string& name,
                            const std::function<void(const std::string&)>& take,
                            const std::string& help) const {
  return Option(app_->add_option_function<std::string>(name, take, help));
}

Option CommandLine::AddNumber(const std::string& name, const std::function<void(double)>& take,
                              const std::string& help) const {
  return Option(app_->add_option_function<double>(
      name, [take](const double& number) { take(number); }, help));
}

Option CommandLine::AddFlag(const std::string& name, bool& value, const std::string& help) const {
  return Option(app_->add_flag(name, value, help));
}

Option CommandLine::Find(const std::string& name) const {
  return Option(app_->get_option(name));
}

CommandLine CommandLine::AddCommand(const std::string& name, const std::string& about) const {
  return CommandLine(app_->get_subcommand_ptr(app_->add_subcommand(name, about)));
}

void CommandLine::RequireCommands(std::size_t least, std::size_t most) const {
  app_->require_subcommand(least, most);
}

void CommandLine::Fallthrough() const {
  app_->fallthrough();
}

void CommandLine::Hide() const {
  app_->group("");
}

void CommandLine::Footer(const std::string& text) const {
  app_->footer(text);
}

void CommandLine::Run(const std::function<void()>& run) const {
  app_->callback(run);
}

void CommandLine::BeforeCommands(const std::function<void()>& run) const {
  app_->parse_complete_callback(run);
}

void AddCommonOptions(const CommandLine& app, const std::string& domain_help, int& domain,
                      std::string& log_level) {
  app.app_->set_version_flag("--version", app.name() + " " PALPATE_VERSION "\nphysics " +
                                              kPhysicsRevision + ", scenes " + kScenesRevision);
  app.Add("--domain", domain, domain_help).Range(0, dds::kMaxDomain).ShowDefault();
  app.Add("--log-level", log_level,
          "least important messages to log: trace, debug, info, warn, error or off")
      .ShowDefault();
  app.AddText(
         "--log-format", [](const std::string& text) { SetLogFormat(ParseLogFormat(text)); },
         "format of the log on standard error: text, or json (one object per line)")
      .ShowDefault("text");
}

void AddNetworkOptions(const CommandLine& app, const std::string& peer, dds::Network& network) {
  app.Add("--network", network.interface,
          "network interface to communicate over, such as eth0.  Use the same network for the "
          "server and all its clients.  lo: this host only.  Traffic is encrypted only with "
          "--identity")
      .TypeName("INTERFACE")
      .ShowDefault();
  app.Add("--peer", network.peers,
          "address of " + peer + "; needed if the network has no multicast; can be repeated")
      .TypeName("ADDRESS");
  app.Add("--identity", network.identity,
          "folder made by 'palpate-identities add': joins a secured domain as this identity.  "
          "Traffic is encrypted and goes over UDP; only programs with an identity of the same "
          "authority take part, each within the rights of its role")
      .TypeName("FOLDER")
      .ExistingFolder();
}

void AddServerOptions(const CommandLine& app, ServerOptions& options) {
  AddNetworkOptions(app, "the server", options.network);
  AddCommonOptions(app, "number of the domain: the same as the server's", options.domain,
                   options.log_level);
}

void AddRealtimeOptions(const CommandLine& app, const std::string& loop,
                        RealtimeOptions& realtime) {
  app.AddText(
         "--realtime",
         [&realtime](const std::string& text) { realtime.mode = ParseRealtimeMode(text); },
         "real-time scheduling of " + loop +
             ".  require: fail if it is not permitted; prefer: use it if permitted; off: do not "
             "use it")
      .ShowDefault("prefer");
  app.Add("--cpu", realtime.cpu, "core to run " + loop + " on, counted from 0; default: any")
      .Range(0, CPU_SETSIZE - 1);
}

void AddEffectsOption(const CommandLine& app) {
  app.AddText(
         "--effects",
         [](const std::string& folder) {
           const char* others = std::getenv("PALPATE_EFFECTS");
           const std::string all = std::filesystem::absolute(folder).string() + ':';
           setenv("PALPATE_EFFECTS", (all + (others ? others : "")).c_str(), 1);
         },
         "folder of effects of your own.  Effects are code: what a scene, a bundle or a recording "
         "names is run only from here, from the folders in PALPATE_EFFECTS (separated by :), and "
         "from those that come with the programs")
      .TypeName("FOLDER")
      .Check([](const std::string& folder) {
        return folder.find(':') == std::string::npos
                   ? ""
                   : "has a : in its name, which separates folders; rename it";
      })
      .ExistingFolder();
}

void AddHostNameOption(const CommandLine& app, const std::string& what,
                       std::vector<std::string>& names) {
  // Validators run from the last to the first.
  app.Add("--host-name", names,
          "host name, such as lab.example, in the URLs by which browsers request " + what +
              "; can be repeated.  By default only localhost and numeric addresses are accepted, "
              "because a foreign web page can direct any name to this host (DNS rebinding)")
      .TypeName("NAME")
      .Transform([](const std::string& name) { return LowerCase(name); })
      .Check([](const std::string& name) {
        return IsHostName(name) ? ""
                                : "'" + name + "' is not a host name; give one such as lab.example";
      });
}

bool ParseCommandLine(const CommandLine& app, int argc, const char* const* argv) {
  MakeNumbersFinite(*app.app_);
  try {
    app.app_->parse(argc, argv);
  } catch (const CLI::Success& wanted) {
    app.app_->exit(wanted);  // prints the help or the version
    return false;
  } catch (const CLI::ParseError& error) {
    std::string what = error.what();
    // What is missing may be present, but misspelt.
    const bool words_left = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr ||
                            dynamic_cast<const CLI::RequiredError*>(&error) != nullptr;
    if (const std::string unknown = words_left ? UnknownWord(*app.app_) : ""; !unknown.empty()) {
      what = unknown;
    }
    throw UsageError(what + "; '" + app.name() + " --help' shows how");
  }
  return true;
}

int RunProgram(const std::string& program, const std::function<int()>& run) noexcept {
  const auto fail = [&](const std::exception& error, int status) {
    std::fputs(LogLine(program, error.what()).c_str(), stderr);
    return status;
  };
  try {
    return run();
  } catch (const UsageError& error) {
    return fail(error, 2);
  } catch (const std::bad_alloc&) {
    return fail(Error("out of memory; 'free' shows the memory of this host, 'ulimit -v' the limit "
                      "for a program"),
                1);
  } catch (const std::exception& error) {
    return fail(error, 1);
  }
}

}  // namespace palpate
