#include "common/program/command_line.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <sched.h>

#include "common/dds/topics.h"
#include "common/error.h"
#include "common/program/log.h"
#include "common/text/lower_case.h"
#include "common/text/nearest_word.h"

namespace palpate {
namespace {

/// Comparisons, CLI11's ranges among them, let NaN pass.
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

/// The options and commands that may stand where the words of these apps do, as they are written.
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

/// Names the first word that nothing takes, an option before all else, and what it may have been
/// meant to be; empty where there is none.
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

void AddCommonOptions(CLI::App& app, const std::string& domain_help, int& domain,
                      std::string& log_level) {
  app.set_version_flag("--version", app.get_name() + " " PALPATE_VERSION);
  app.add_option("--domain", domain, domain_help)
      ->check(CLI::Range(0, dds::kMaxDomain))
      ->capture_default_str();
  app.add_option("--log-level", log_level, "trace, debug, info, warn, error or off")
      ->capture_default_str();
  app.add_option_function<std::string>(
         "--log-format", [](const std::string& text) { SetLogFormat(ParseLogFormat(text)); },
         "format of the log on standard error: text, or json with one object a line")
      ->default_str("text");
}

void AddNetworkOptions(CLI::App& app, const std::string& peer, dds::Network& network) {
  app.add_option("--network", network.interface,
                 "network interface, as eth0, over which server, stations and viewers talk.  Give "
                 "it to all of them, also to the server.  lo: programs of this host alone.  Only "
                 "--identity encrypts what is sent")
      ->type_name("INTERFACE")
      ->capture_default_str();
  app.add_option("--peer", network.peers,
                 "address of " + peer +
                     ", needed where the network carries no multicast; may be given again")
      ->type_name("ADDRESS");
  app.add_option("--identity", network.identity,
                 "folder that 'palpate-identities add' made: who this program is in a secured "
                 "domain.  What it sends is then encrypted, and goes over UDP.  It hears only "
                 "programs with an identity of the same authority, and each may do what its role "
                 "allows")
      ->type_name("FOLDER")
      ->check(CLI::ExistingDirectory);
}

void AddRealtimeOptions(CLI::App& app, const std::string& loop, RealtimeOptions& realtime) {
  app.add_option_function<std::string>(
         "--realtime",
         [&realtime](const std::string& text) { realtime.mode = ParseRealtimeMode(text); },
         "real-time scheduling of " + loop +
             ".  require: fail without the rights; prefer: use it if it is allowed; off: do "
             "without")
      ->default_str("prefer");
  app.add_option("--cpu", realtime.cpu,
                 "processor core for " + loop + ", a number from 0; default: any")
      ->check(CLI::Range(0, CPU_SETSIZE - 1));
}

bool ParseCommandLine(CLI::App& app, int argc, const char* const* argv) {
  MakeNumbersFinite(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& wanted) {
    app.exit(wanted);  // prints the help or the version
    return false;
  } catch (const CLI::ParseError& error) {
    std::string what = error.what();
    // What is missing may be there, misspelt.
    const bool words_left = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr ||
                            dynamic_cast<const CLI::RequiredError*>(&error) != nullptr;
    if (const std::string unknown = words_left ? UnknownWord(app) : ""; !unknown.empty()) {
      what = unknown;
    }
    throw UsageError(what + "; '" + app.get_name() + " --help' shows how");
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
    return fail(Error("there is not enough memory for this; 'free' says what the host has, and "
                      "'ulimit -v' what this program may take"),
                1);
  } catch (const std::exception& error) {
    return fail(error, 1);
  }
}

}  // namespace palpate
