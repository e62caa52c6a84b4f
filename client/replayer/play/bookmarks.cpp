#include "client/replayer/play/bookmarks.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include <nlohmann/json.hpp>

#include "common/error.h"
#include "common/files/output.h"
#include "common/files/whole_file.h"
#include "common/json/json_file.h"

namespace palpate {
namespace {

constexpr double kLongest_s = 1e6;
/// 200 names of 100 bytes, each byte escaped as up to six characters, plus layout.
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 20;

bool IsUtf8(const std::string& text) {
  try {
    nlohmann::json(text).dump();
    return true;
  } catch (const nlohmann::json::type_error&) {
    return false;
  }
}

/// Returns a name fit for a list: without control characters, and without spaces at its ends.
/// Throws Error if nothing is left, or too much.
std::string Shown(std::string name) {
  std::ranges::replace_if(
      name, [](unsigned char c) { return c < ' ' || c == 0x7f; }, ' ');
  const auto first = name.find_first_not_of(' ');
  if (first == std::string::npos) throw Error("a bookmark needs a name");
  name = name.substr(first, name.find_last_not_of(' ') - first + 1);
  if (name.size() > Bookmarks::kLongestName) {
    throw Error("the name of a bookmark has at most " + std::to_string(Bookmarks::kLongestName) +
                " bytes; shorten it");
  }
  // The file's next reader would refuse it.
  if (!IsUtf8(name)) throw Error("the name of a bookmark must be UTF-8; type it again");
  return name;
}

std::string TextOf(const std::string& file) {
  std::error_code ignored;
  return std::filesystem::exists(file, ignored) ? ReadWholeFile(file, kMostBytes) : "";
}

}  // namespace

std::string Bookmarks::FileFor(const std::string& recording) {
  const std::string ending = ".mcap";
  const std::size_t name = recording.size() - (recording.ends_with(ending) ? ending.size() : 0);
  return recording.substr(0, name) + ".bookmarks.json";
}

Bookmarks::Bookmarks(std::string file) : file_(std::move(file)), text_(TextOf(file_)) {
  std::error_code ignored;
  if (!std::filesystem::exists(file_, ignored)) return;
  const JsonNode root = JsonNode::Parse(text_, file_);
  root.AllowOnly({"bookmarks"});
  const JsonNode list = root.At("bookmarks");
  const std::vector<JsonNode> items = list.Items();
  if (items.size() > kMost) list.Fail("holds more than " + std::to_string(kMost) + "; drop some");
  for (const JsonNode& item : items) {
    item.AllowOnly({"at_s", "name"});
    const JsonNode name = item.At("name");
    const double at_s = item.At("at_s").Number(0.0, kLongest_s);
    try {
      bookmarks_.push_back({next_++, at_s, Shown(name.String())});
    } catch (const Error& error) {
      name.Fail(error.what());
    }
  }
  std::ranges::stable_sort(bookmarks_, {}, &Bookmark::at_s);
}

void Bookmarks::Add(double at_s, const std::string& name) {
  const std::string shown = Shown(name);
  if (!(at_s >= 0.0 && at_s <= kLongest_s)) throw Error("there is no such time in the recording");
  if (bookmarks_.size() >= kMost) {
    throw Error("there are " + std::to_string(kMost) + " bookmarks already; drop one first");
  }
  std::vector<Bookmark> bookmarks = bookmarks_;
  const auto after = std::ranges::upper_bound(bookmarks, at_s, {}, &Bookmark::at_s);
  bookmarks.insert(after, {next_, at_s, shown});
  Write(std::move(bookmarks));
  ++next_;
}

void Bookmarks::Drop(std::uint32_t number) {
  std::vector<Bookmark> bookmarks = bookmarks_;
  if (std::erase_if(bookmarks, [&](const Bookmark& b) { return b.number == number; }) == 0) {
    throw Error("that bookmark no longer exists");
  }
  Write(std::move(bookmarks));
}

void Bookmarks::Write(std::vector<Bookmark> bookmarks) {
  if (TextOf(file_) != text_) {
    throw Error(file_ + ": was changed by another program; restart the replay to read it again");
  }
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Bookmark& bookmark : bookmarks) {
    list.push_back({{"at_s", bookmark.at_s}, {"name", bookmark.name}});
  }
  const std::string text = nlohmann::ordered_json{{"bookmarks", list}}.dump(2) + "\n";
  WriteOutput("bookmarks", file_, text);
  text_ = text;
  bookmarks_ = std::move(bookmarks);
}

}  // namespace palpate
