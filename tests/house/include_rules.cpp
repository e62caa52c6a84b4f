#include "tests/house/include_rules.h"

#include <algorithm>
#include <optional>
#include <regex>
#include <set>
#include <sstream>

#include "tests/house/source_tree.h"

namespace palpate::house {
namespace {

using Paths = std::vector<std::string>;

/// What the files of a folder (or one file) may include; the longest path that matches a file
/// applies.
struct Rule {
  std::string who;
  Paths project;    ///< folders and files of the project
  Paths not_these;  ///< exceptions from `project`
  Paths libraries;  ///< named as in kLibraries
};

// tests/ has no rule: a test may look at anything.
const std::vector<Rule> kRules = {
    // The wire types depend on nothing.
    {"idl", {}, {}, {}},
    {"common", {"common"}, {"common/dds"}, {"Eigen", "spdlog"}},
    // What all programs' command lines and logs share.  Of DDS it has the range of domains and
    // where to look, not the library.
    {"common/program/command_line.h",
     {"common/program/realtime.h", "common/program/log.h", "common/dds/network.h"},
     {},
     {}},
    {"common/program/command_line.cpp",
     {"common/program/command_line.h", "common/dds/topics.h", "common/error.h",
      "common/http/host_name.h", "common/program/log.h", "common/revision.h",
      "common/text/joined.h", "common/text/lower_case.h", "common/text/nearest_word.h",
      "common/text/wrapped.h"},
     {},
     {"CLI11"}},
    // How a scene's name and its content belong together, for whoever receives one.
    {"common/files/bundle_hash.cpp",
     {"common/files/bundle_hash.h", "common/error.h"},
     {},
     {"xxHash"}},
    // The only place that knows Cyclone DDS: all others see typed readers and writers.
    {"common/dds", {"common", "idl"}, {}, {"Eigen", "spdlog", "Cyclone DDS", "OpenSSL"}},
    // Only files: their readers need not know DDS.
    {"common/mcap", {"common"}, {"common/dds"}, {"zlib", "zstd"}},
    // What the project stores in them: samples, as DDS serialises them.
    {"common/recording", {"common"}, {}, {"Eigen", "spdlog"}},
    // The only place that names metrics and serves them to Prometheus: in its text format, by
    // Boost's HTTP server.
    {"common/metrics", {"common"}, {"common/dds"}, {"Eigen", "spdlog", "Prometheus", "Boost"}},
    {"common/http/boost_source.cpp", {}, {}, {"Boost"}},
    {"common/http/host_name.cpp", {"common/http/host_name.h", "common/text"}, {}, {}},
    // Files that people write, for scenes and devices alike.
    {"common/json", {"common"}, {"common/dds"}, {"Eigen", "spdlog", "nlohmann-json"}},
    {"scenes",
     {"common", "scenes", "idl/scene_generated.h"},
     {"common/dds"},
     {"Eigen", "spdlog", "nlohmann-json", "FlatBuffers", "xxHash", "libpng"}},
    // Readers stay in one small program; zlib is for meshes that come as .gz.  assimp, with its
    // headers and many formats, is there for 3DS only.
    {"scenes/importer", {"common", "scenes"}, {"common/dds"}, {"Eigen", "spdlog", "zlib"}},
    {"scenes/importer/3ds_reader.cpp",
     {"common/error.h", "scenes/importer"},
     {},
     {"Eigen", "assimp"}},
    // A pure function of tree, state and pose: no transport, no log, no files.
    {"server/physics",
     {"common", "server/physics", "scenes/scene.h", "scenes/moved_group.h", "scenes/free_body.h",
      "scenes/sphere_tree.h", "scenes/sphere_packet.h", "scenes/grid", "scenes/effects"},
     {"common/dds"},
     {"Eigen"}},
    // Of scenes only scene.h: a session's model is made from a scene's trees and coupling, and from
    // nothing that reads files.
    {"server/session",
     {"common", "server/physics", "server/session", "scenes/scene.h", "scenes/grid"},
     {},
     {"Eigen", "spdlog"}},
    // What others link into their programs: Eigen, and no other library.
    {"server/library",
     {"common", "scenes", "server/physics", "server/library"},
     {"common/dds"},
     {"Eigen"}},
    {"server", {"common", "scenes", "server"}, {}, {"Eigen", "spdlog"}},
    // A device knows no server and no wire.
    {"devices", {"common", "devices"}, {"common/dds"}, {"Eigen", "spdlog"}},
    {"devices/openhaptics",
     {"common", "devices"},
     {"common/dds"},
     {"Eigen", "spdlog", "OpenHaptics"}},
    // A service that speaks JSON over a WebSocket.
    {"devices/haply",
     {"common", "devices"},
     {"common/dds"},
     {"Eigen", "spdlog", "nlohmann-json", "Boost"}},
    {"devices/spacemouse", {"common", "devices"}, {"common/dds"}, {"Eigen", "spdlog", "spacenav"}},
    // Neither DDS nor sockets: what the people of a course may do and did; OpenSSL for tokens,
    // minizip for what a person is given, ICU for their names.  SQL is for its tables alone.
    {"client/course",
     {"common", "scenes", "client/course"},
     {"common/dds", "client/course/sql.inl"},
     {"Eigen", "spdlog", "nlohmann-json", "OpenSSL", "minizip", "ICU"}},
    {"client/course/course_file.cpp", {"common", "client/course"}, {}, {"spdlog", "SQLite"}},
    {"client/course/sql.inl", {"client/course"}, {}, {"SQLite"}},
    {"client/course/exam_table.cpp", {"common", "client/course"}, {}, {"spdlog", "nlohmann-json"}},
    {"client/course/roster_table.cpp", {"common", "client/course"}, {}, {}},
    {"client/course/trial_table.cpp", {"client/course"}, {}, {}},
    // Never the server or another client; the own folder is added below.  Boost for HTTP servers
    // and WebSockets (Asio, Beast); OpenSSL for TLS; zlib to send a scene compressed.
    {"client/viewer",
     {"common", "client/course", "client/viewer"},
     {},
     {"Eigen", "spdlog", "nlohmann-json", "Boost", "OpenSSL", "zlib"}},
    // The load consists of simulated stations, so this client may use another: the station. Boost
    // for the viewers' WebSockets, as in the gateway.
    {"client/load",
     {"common", "scenes", "devices", "client/load", "client/station"},
     {},
     {"Eigen", "spdlog", "nlohmann-json", "Boost"}},
    // The library of server/library, for Python.
    {"client/python",
     {"server/library/scenes.h", "server/library/physics.h", "common/error.h", "common/math",
      "common/files/project_files.h", "common/program/machine.h", "common/realtime/steady_clock.h",
      "common/revision.h", "scenes/files/scene_bundle.h", "scenes/mesh/mesh_export.h",
      "client/python"},
     {"client/python/live"},
     {"pybind11"}},
    // A station like any other, whose hand a Python program moves: it runs the station's own loop.
    {"client/python/live",
     {"common", "devices", "client/station", "client/python/arrays.h",
      "client/python/held_wrench.h", "client/python/live", "client/python/signals.h"},
     {},
     {"Eigen", "pybind11"}},
    // Programs of other people's.
    {"client/examples", {}, {}, {"Palpate"}},
    // A force that ROS asks for becomes an aim of the station's guide, by the guide's own figures.
    {"client/crtk", {"common", "client/crtk", "client/station/guide.h"}, {}, {"Eigen", "spdlog"}},
    {"client/igtl", {"common", "client/igtl"}, {}, {"Eigen", "spdlog", "OpenIGTLink"}},
    {"client", {"common", "scenes", "devices"}, {}, {"Eigen", "spdlog", "nlohmann-json"}},
    {"client/lesson", {"common", "client/lesson", "client/course"}, {}, {"Eigen", "spdlog"}},
    // The only client that knows the server's insides: to verify a recording is to run its loop.
    {"client/replayer",
     {"common", "scenes", "client/course", "client/replayer", "server/physics", "server/session"},
     {},
     {"Eigen", "spdlog", "nlohmann-json"}},
};

/// A folder with floors: a file includes what is on its own floor or below.
struct Floors {
  std::string folder;
  std::vector<Paths> from_below;  ///< folders, and files without their suffix
  /// Whether files that are not listed are on the top floor; else each must be listed.
  bool rest_on_top;
};

// server/physics: pairs of spheres (tree) and of triangles (surface, contact) become rows, rows a
// pose and its forces (solve), and the step calls them in turn.  The kernels are at the very
// bottom, in one folder instead of on the floors that they serve: they are one table, compiled once
// for each instruction set.  The model is above tree and surface because it owns both, and below
// rows because every stage reads it.  scenes: meshes are read or generated, trees are built over
// them, and the compiler joins them as a scene's file says.  common: at the bottom what everybody
// may use, on top what knows the most (recordings, a whole program).
const std::vector<Floors> kFloors = {
    {"common",
     {
         {"common/error", "common/bur_button", "common/revision", "common/step_fault",
          "common/coupling_fault", "common/step_tuning", "common/text", "common/math", "common/qp",
          "common/realtime"},
         {"common/files", "common/http", "common/mcap"},
         {"common/dds", "common/json", "common/metrics"},
         {"common/program", "common/recording"},
     },
     false},
    {"server/physics",
     {
         {"server/physics/limits"},
         {"server/physics/simd"},
         {"server/physics/step_types"},
         {"server/physics/energy"},
         {"server/physics/tree"},
         {"server/physics/cut"},
         {"server/physics/surface"},
         {"server/physics/haptic_model", "server/physics/scene_model", "server/physics/step_state"},
         {"server/physics/rows"},
         {"server/physics/contact"},
         {"server/physics/solve"},
         {"server/physics/haptic_step"},
         // It uses the step.
         {"server/physics/start_pose"},
     },
     false},
    {"scenes",
     {
         {"scenes/effects"},
         {"scenes/scene", "scenes/moved_group", "scenes/free_body", "scenes/sphere_tree",
          "scenes/sphere_packet", "scenes/progress"},
         {"scenes/mesh"},
         {"scenes/grid", "scenes/importer", "scenes/shapes"},
         {"scenes/tree"},
         {"scenes/files"},
     },
     true},
};

const Floors* FloorsOf(const std::string& path) {
  const auto found = std::find_if(kFloors.begin(), kFloors.end(),
                                  [&](const Floors& f) { return IsBelow(path, f.folder); });
  return found == kFloors.end() ? nullptr : &*found;
}

/// The floor, from 0; nullopt: the file must be listed, and is not.
std::optional<std::size_t> FloorOf(const Floors& floors, const std::string& path) {
  for (std::size_t floor = 0; floor < floors.from_below.size(); ++floor) {
    for (const std::string& place : floors.from_below[floor]) {
      if (IsBelow(path, place) || path.starts_with(place + ".")) return floor;
    }
  }
  if (floors.rest_on_top) return floors.from_below.size();
  return std::nullopt;
}

// Library headers by their prefix.  A new library is a decision: it is entered here and in a rule.
const std::vector<std::pair<std::string, std::string>> kLibraries = {
    {"Eigen/", "Eigen"},
    {"spdlog/", "spdlog"},
    {"CLI/", "CLI11"},
    {"dds/", "Cyclone DDS"},
    {"iceoryx", "iceoryx"},
    {"assimp/", "assimp"},
    {"nlohmann/", "nlohmann-json"},
    {"flatbuffers/", "FlatBuffers"},
    {"xxhash.h", "xxHash"},
    {"png.h", "libpng"},
    {"zlib.h", "zlib"},
    // Recordings are compressed with zstd: of the two formats that MCAP knows it makes smaller
    // files.
    {"zstd.h", "zstd"},
    {"boost/", "Boost"},
    // Hashes and random keys.
    {"openssl/", "OpenSSL"},
    {"SQLiteCpp/", "SQLite"},
    {"sqlite3.h", "SQLite"},
    {"minizip/", "minizip"},
    {"unicode/", "ICU"},
    {"fmt/", "spdlog"},
    {"HD/", "OpenHaptics"},
    {"HDU/", "OpenHaptics"},
    {"HL/", "OpenHaptics"},
    {"spnav.h", "spacenav"},
    {"prometheus/", "Prometheus"},
    {"pybind11/", "pybind11"},
    {"palpate", "Palpate"},  // as installed
    {"igtl", "OpenIGTLink"},
    // Another vendor's DDS, in tests/crtk alone.
    {"fastcdr/", "Fast DDS"},
    {"fastdds/", "Fast DDS"},
    {"gtest/", "GoogleTest"},
    {"gmock/", "GoogleTest"},
    {"benchmark/", "benchmark"},
    // Peers, in tests/benchmarks/peers alone.
    {"btBulletDynamicsCommon.h", "Bullet"},
    {"BulletCollision/", "Bullet"},
    {"mujoco/", "MuJoCo"},
    {"ode/", "ODE"},
};

// Slow to compile: in .cpp files only.
const Paths kNotInHeaders = {"CLI11", "assimp", "nlohmann-json", "spdlog", "SQLite", "ICU"};

/// Headers of the C++ library have no dot; those of C and POSIX have no folder or a system one.
bool IsSystemHeader(const std::string& header) {
  static const std::regex kSystem(
      R"([a-z_0-9]+|(sys|linux|netinet|arpa|net)/[a-z_0-9]+\.h|)"
      R"((cpuid|cxxabi|dirent|dlfcn|errno|execinfo|fcntl|features|getopt|ifaddrs|immintrin|malloc|netdb|poll|)"
      R"(pthread|pty|pwd|sched|semaphore|signal|spawn|stddef|stdint|stdio|stdlib|string|termios|time|unistd|)"
      R"(x86intrin|xmmintrin)\.h)");
  return std::regex_match(header, kSystem);
}

std::optional<std::string> LibraryOf(const std::string& header) {
  for (const auto& [begin, library] : kLibraries) {
    if (header.starts_with(begin)) return library;
  }
  return std::nullopt;
}

const Rule* RuleFor(const std::string& path) {
  const Rule* best = nullptr;
  for (const Rule& rule : kRules) {
    if (IsBelow(path, rule.who) && (!best || rule.who.size() > best->who.size())) best = &rule;
  }
  return best;
}

bool Allows(const Rule& rule, const std::string& path, const std::string& include) {
  const auto holds = [&](const std::string& folder) { return IsBelow(include, folder); };
  if (std::any_of(rule.not_these.begin(), rule.not_these.end(), holds)) return false;
  if (std::any_of(rule.project.begin(), rule.project.end(), holds)) return true;
  // E.g. client/station/main.cpp may include client/station/..., and no other client.
  const std::size_t own_end = path.find('/', std::string("client/").size());
  return rule.who == "client" && own_end != std::string::npos && holds(path.substr(0, own_end));
}

std::string Join(const Paths& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text.empty() ? "nothing" : text;
}

/// The build makes idl/x.h and idl/x_generated.h with idlc and flatc, and x.h from x.h.in.
bool IsGenerated(const std::string& include,
                 const std::function<bool(const std::string&)>& exists) {
  static const std::regex kIdl(R"((idl/[a-z0-9_]+)\.h)"), kFlat(R"((idl/[a-z_]+)_generated\.h)");
  std::smatch match;
  return exists(include + ".in") ||
         (std::regex_match(include, match, kFlat) && exists(match[1].str() + ".fbs")) ||
         (std::regex_match(include, match, kIdl) && exists(match[1].str() + ".idl"));
}

// C and C++ write #include, IDL as well, FlatBuffers `include "x";`.
const std::regex kInclude(R"re(^\s*#?\s*include\s*([<"])([^>"]+)[>"])re");

}  // namespace

std::vector<std::string> IncludeViolations(const std::string& path, const std::string& text,
                                           const std::function<bool(const std::string&)>& exists) {
  std::vector<std::string> violations;
  const Floors* floors = FloorsOf(path);
  const std::optional<std::size_t> floor = floors ? FloorOf(*floors, path) : std::nullopt;
  if (floors && !floor) {
    violations.push_back(path + ":1: stands on no floor of " + floors->folder +
                         ": enter it in tests/house/include_rules.cpp");
  }
  const Rule* rule = RuleFor(path);
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::smatch match;
    if (!std::regex_search(line, match, kInclude)) continue;
    const std::string include = match[2];
    const auto violation = [&](const std::string& what) {
      violations.push_back(path + ":" + std::to_string(number) + ": " + include + ": " + what);
    };

    if (match[1] == "\"") {
      if (!exists(include) && !IsGenerated(include, exists)) {
        violation("no such file: includes are spelled from the root, libraries in <>");
      } else if (rule && !Allows(*rule, path, include)) {
        violation(rule->who + " may include of the project: " + Join(rule->project) +
                  (rule->not_these.empty() ? "" : ", but not " + Join(rule->not_these)));
      } else if (floor && FloorsOf(include) == floors &&
                 FloorOf(*floors, include).value_or(0) > *floor) {
        violation("stands above " + Join(floors->from_below[*floor]) +
                  ": move what both want down, or what wants it up");
      }
    } else if (const auto library = LibraryOf(include)) {
      const auto is_it = [&](const std::string& name) { return name == *library; };
      if (rule && std::none_of(rule->libraries.begin(), rule->libraries.end(), is_it)) {
        violation(rule->who + " may use of the libraries: " + Join(rule->libraries));
      } else if (rule && path.ends_with(".h") &&
                 std::any_of(kNotInHeaders.begin(), kNotInHeaders.end(), is_it)) {
        violation(*library + " is slow to compile: include it in .cpp files only");
      }
    } else if (!IsSystemHeader(include)) {
      violation("unknown library: enter it in tests/house/include_rules.cpp");
    }
  }
  return violations;
}

std::vector<std::string> ProjectIncludes(const std::string& text) {
  std::vector<std::string> includes;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (std::regex_search(line, match, kInclude) && match[1] == "\"") includes.push_back(match[2]);
  }
  return includes;
}

std::vector<std::string> IncludeCircle(
    const std::map<std::string, std::vector<std::string>>& includes) {
  std::set<std::string> done;
  std::vector<std::string> way;
  const std::function<bool(const std::string&)> leads_round = [&](const std::string& file) {
    const auto begin = std::find(way.begin(), way.end(), file);
    const bool round = begin != way.end();
    if (round) way.erase(way.begin(), begin);
    way.push_back(file);
    if (round) return true;
    if (const auto found = includes.find(file); found != includes.end() && !done.contains(file)) {
      for (const std::string& next : found->second) {
        if (leads_round(next)) return true;
      }
    }
    done.insert(file);
    way.pop_back();
    return false;
  };
  for (const auto& [file, _] : includes) {
    if (leads_round(file)) return way;
  }
  return {};
}

}  // namespace palpate::house
