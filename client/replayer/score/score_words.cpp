#include "client/replayer/score/score_words.h"

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "common/text/quoted.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

/// Returns the catalogues' words, English first.
const std::vector<Json>& Catalogues() {
  static const std::vector<Json> all = [] {
    std::vector<Json> words;
    for (const auto& [tag, text] : kScoreCatalogues) words.push_back(Json::parse(text));
    return words;
  }();
  return all;
}
const Json& English() {
  return Catalogues().front();
}

/// Returns JSON as the value of an attribute in single quotes.
std::string Attribute(const char* name, const Json& json) {
  const std::string text = Escaped(json.dump(-1, ' ', true, Json::error_handler_t::replace));
  std::string attribute = fmt::format(" {}='", name);
  for (const char c : text) attribute += c == '\'' ? "&#39;" : std::string(1, c);
  return attribute + "'";
}

std::string Joined(const std::vector<LocalText>& texts) {
  std::string all;
  for (const LocalText& text : texts) all += (all.empty() ? "" : ", ") + EnglishOf(text);
  return all;
}

/// Returns a text in the language of `words`, with English values.
std::string In(const Json& words, const std::string& key, const Values& values) {
  std::string text = words.value(key, key);
  for (const Said& said : values) {
    const std::string name = "{" + said.name + "}";
    const std::size_t at = text.find(name);
    if (at != text.npos) text.replace(at, name.size(), Joined(said.values));
  }
  return text;
}

}  // namespace

std::string Escaped(const std::string& text) {
  std::string out;
  for (const char c : Printable(text)) {
    out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  }
  return out;
}

std::string InEnglish(const std::string& key, const Values& values) {
  return In(English(), key, values);
}

LocalText InAll(const std::string& key, const Values& values) {
  LocalText text;
  for (std::size_t i = 0; i < kScoreCatalogues.size(); ++i) {
    text[std::string(kScoreCatalogues[i].first)] = In(Catalogues()[i], key, values);
  }
  return text;
}

std::string KeyAttribute(const std::string& key) {
  return English().contains(key) ? " data-say=\"" + key + "\"" : "";
}

std::string Say(const std::string& key, const Values& values) {
  Json json = Json::object();
  for (const Said& said : values) json[said.name] = said.values;
  return "<span" + KeyAttribute(key) + (values.empty() ? "" : Attribute("data-values", json)) +
         ">" + Escaped(InEnglish(key, values)) + "</span>";
}

std::string Say(const LocalText& text, const std::string& instead) {
  if (text.size() < 2) return Escaped(text.empty() ? instead : EnglishOf(text));
  return "<span" + Attribute("data-text", text) + ">" + Escaped(EnglishOf(text)) + "</span>";
}

std::string Label(const std::string& key) {
  return fmt::format(" data-label=\"{}\" aria-label=\"{}\"", key, Escaped(InEnglish(key)));
}

std::string ScoreCatalogues() {
  std::string all = "{";
  for (const auto& [tag, words] : kScoreCatalogues) all += fmt::format("\"{}\":{},", tag, words);
  return all + "}";
}

}  // namespace palpate
